"""Writes H.264 video."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import cast

import av
import numpy as np
from numpy.typing import NDArray

Frame = NDArray[np.uint8]
"""A picture, (H, W, 3) uint8 RGB, row 0 at the top."""


class VideoWriter:
    """Writes H.264 in MP4, for people to look at or, with `crf` 0, without loss in RGB.

    The same pictures give the same bytes, with one release of x264, on any x86-64.

    Parameters
    ----------
    path : Path
    size : tuple of int
        Width and height in pixels; odd sizes are cut by one for 4:2:0 video.
    rate : float
        Frames per second.
    crf : int
        x264's quality, 18 by default; 0 is lossless RGB.
    preset : str
        How long x264 looks for smaller files.
    """

    def __init__(
        self,
        path: Path,
        size: tuple[int, int],
        rate: float,
        crf: int = 18,
        preset: str = "veryfast",
    ) -> None:
        self._container = av.open(str(path), "w")
        codec = "libx264rgb" if crf == 0 else "libx264"
        stream = cast(
            "av.VideoStream",  # PyAV's types know few codecs by their names
            self._container.add_stream(codec, rate=Fraction(rate).limit_denominator(1000)),
        )
        even = 1 if crf == 0 else 2
        self._size = size[0] // even * even, size[1] // even * even
        stream.width, stream.height = self._size
        stream.pix_fmt = "rgb24" if crf == 0 else "yuv420p"
        # With several threads, or the kernels that suit one machine best, x264 does not
        # always write the same bytes for the same pictures.
        stream.options = {
            "crf": str(crf),
            "preset": preset,
            "x264-params": "threads=1:lookahead-threads=1:asm=sse4.2",
        }
        self._stream = stream
        self._time_base = 1 / Fraction(rate).limit_denominator(1000)
        self._next = 0

    def write(self, frame: Frame, time: float | None = None) -> None:
        """Append one frame, (H, W, 3) uint8 RGB; shown at about `time`, s, if that is later."""
        cut = np.ascontiguousarray(frame[: self._size[1], : self._size[0]])
        picture = av.VideoFrame.from_ndarray(cut, format="rgb24")
        due = 0 if time is None else round(time / self._time_base)
        picture.pts, picture.time_base = max(self._next, due), self._time_base
        self._next = picture.pts + 1
        self._container.mux(self._stream.encode(picture))

    def close(self) -> None:
        """Flush and close the file."""
        self._container.mux(self._stream.encode())
        self._container.close()

    def __enter__(self) -> VideoWriter:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
