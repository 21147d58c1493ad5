"""Mirrored and halved clips, and how far their runs agree with those of the clips as they are.

No truth is needed: a mirrored mouth opens as far, and half the pixels show the same lips. Run it by
hand, first to make the clips, then to compare the runs that `abs-engine track` made of both:

    python tests/altered_clips.py make CLIPS ALTERED
    python tests/altered_clips.py compare RUNS ALTERED_RUNS
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.tracking.record import load_run

Image = NDArray[np.uint8]


def mirrored(image: Image) -> Image:
    """The picture in a mirror."""
    return np.ascontiguousarray(image[:, ::-1])


def halved(image: Image) -> Image:
    """The picture at half its width and height."""
    return np.asarray(cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA))


WAYS: dict[str, Callable[[Image], Image]] = {"mirrored": mirrored, "half": halved}


def rewrite(source: Path, target: Path, change: Callable[[Image], Image]) -> None:
    """Write a video whose pictures are changed."""
    with av.open(str(source)) as read, av.open(str(target), "w") as written:
        rate = read.streams.video[0].average_rate
        stream = None
        for frame in read.decode(video=0):
            image = change(frame.to_ndarray(format="rgb24"))
            height, width = (n - n % 2 for n in image.shape[:2])
            if stream is None:
                stream = written.add_stream("libx264", rate=rate, options={"crf": "15"})
                stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
            picture = np.ascontiguousarray(image[:height, :width])
            written.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        written.mux(stream.encode() if stream else [])


def compared(runs: Path, altered: Path) -> Iterator[str]:
    """A line for each altered run that has a run of the clip as it is."""
    for folder in sorted(altered.iterdir()):
        name, _, way = folder.name.rpartition("-")
        if way not in WAYS or not (runs / name).is_dir():
            continue
        plain, other = load_run(runs / name), load_run(folder)
        both = plain["found"] & other["found"]
        one, two = (run["aperture"][both] for run in (plain, other))
        off = np.sqrt(np.mean((one - two) ** 2))
        wide = np.corrcoef(plain["width"][both], other["width"][both])[0, 1]
        yield (
            f"{folder.name:14} found {other['found'].sum()} of {plain['found'].sum()}  aperture r "
            f"{np.corrcoef(one, two)[0, 1]:.3f}, {off:.2f} mm rms of {one.std():.1f} sd  "
            f"width r {wide:.2f}  closed {plain['closed'].sum()} and {other['closed'].sum()}, "
            f"both {(plain['closed'] & other['closed']).sum()}"
        )


if __name__ == "__main__":
    what, first, second = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
    if what == "make":
        second.mkdir(parents=True, exist_ok=True)
        for clip in sorted(p for p in first.iterdir() if p.suffix in (".mp4", ".mpg")):
            for way, change in WAYS.items():
                rewrite(clip, second / f"{clip.stem}-{way}.mp4", change)
    else:
        sys.stdout.write("\n".join(compared(first, second)) + "\n")
