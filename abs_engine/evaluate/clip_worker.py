"""The process that `abs-engine bench --clip` times: one clip, tracked as the command tracks it.

`python -m abs_engine.evaluate.clip_worker VIDEO RUN RENDERER BEGUN` writes a line of JSON. BEGUN is
the monotonic clock when it was started.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

from abs_engine.core.garbage import collect_seldom


def main() -> int:
    """Track the clip; say when frames were done."""
    video, run, renderer, begun = sys.argv[1:]
    collect_seldom()
    from abs_engine.core.threads import begin
    from abs_engine.tracking.start import beforehand

    begin(beforehand.load, None, True)
    from abs_engine.render.select import opened_renderer
    from abs_engine.tracking.options import TrackOptions
    from abs_engine.tracking.run import track_video

    done: list[float] = []

    def progress(_count: int, _frames: int) -> None:
        done.append(time.monotonic() - float(begun))

    with opened_renderer(renderer) as drawn:
        told = track_video(Path(video), Path(run), drawn, TrackOptions(), progress)
        said = {"done": done, "summary": told["summary"], "timing": told["timing"]}
        said["draws"] = drawn.description
        sys.stdout.write(json.dumps(said) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
