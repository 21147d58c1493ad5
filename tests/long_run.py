"""Memory, time a frame and OpenGL objects of one process that tracks a very long video.

Run it by hand, with a clip, which is played forwards and backwards until it is long enough:

    python tests/long_run.py CLIP 20000 [cpu|gl] [EVERY]

After every 1,000 (or EVERY) frames it prints the resident memory, the processor's time a frame
since the line before, and how many OpenGL objects live; last, the most memory that it took.
"""

from __future__ import annotations

import resource
import sys
import tempfile
import time
from itertools import chain, cycle, islice
from pathlib import Path

import av
import psutil
from gl_objects import live_objects

from abs_engine.render.context import GLContext
from abs_engine.render.select import open_renderer
from abs_engine.tracking.run import track_video


def lengthened(clip: Path, count: int, path: Path) -> None:
    """Write a video of so many frames: there and back again, so that nothing jumps."""
    with av.open(str(clip)) as read:
        frames = [frame.reformat(format="yuv420p") for frame in read.decode(video=0)]
    with av.open(str(path), "w") as written:
        stream = written.add_stream("libx264", rate=25, options={"preset": "ultrafast"})
        stream.width, stream.height, stream.pix_fmt = frames[0].width, frames[0].height, "yuv420p"
        for frame in islice(cycle(chain(frames, frames[-2:0:-1])), count):
            frame.pts = None
            written.mux(stream.encode(frame))
        written.mux(stream.encode())


class Watch:
    """Prints a line now and then; called after every frame."""

    def __init__(self, every: int) -> None:
        self._every, self._process, self._spent = every, psutil.Process(), time.process_time()

    def __call__(self, done: int, _all: int) -> None:
        if done % self._every:
            return
        spent = time.process_time()
        context = GLContext.of_process()
        objects = None if context is None else sum(live_objects(context).values())
        sys.stdout.write(
            f"{done:6} frames  {self._process.memory_info().rss / 1e6:6.1f} MB  "
            f"{1e3 * (spent - self._spent) / self._every:6.1f} ms a frame  GL objects: {objects}\n"
        )
        sys.stdout.flush()
        self._spent = time.process_time()


def main() -> None:
    """Track the video that is made of the clip, in this process."""
    clip, count, *more = sys.argv[1:]
    kind, every = [*more, *("cpu", "1000")[len(more) :]]
    with tempfile.TemporaryDirectory() as made:
        video = Path(made) / "long.mp4"
        lengthened(Path(clip), int(count), video)
        with open_renderer(kind) as renderer:
            track_video(video, Path(made) / "run", renderer, progress=Watch(int(every)))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6
    rss = psutil.Process().memory_info().rss / 1e6
    sys.stdout.write(f"{rss:.1f} MB at the end, {peak:.1f} MB at most\n")


if __name__ == "__main__":
    main()
