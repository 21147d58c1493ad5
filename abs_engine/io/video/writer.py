"""Writes H.264 video."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import ExitStack
from fractions import Fraction
from pathlib import Path
from typing import cast

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.io.files import scratch

Frame = NDArray[np.uint8]
"""A picture, (H, W, 3) uint8 RGB, row 0 at the top."""


_SLOW = 0.01  # frames per second, from which on down whole seconds are exact enough
_CLOCK = Fraction(1, 90_000)  # s, of MPEG: holds milliseconds and common frame rates exactly


class VideoWriter:
    """Writes H.264 in MP4, for people to look at or, with `crf` 0, without loss in RGB.

    The same pictures give the same bytes, with one release of x264, on any x86-64.

    Parameters
    ----------
    size : tuple of int
        Width and height in pixels; odd sizes are cut by one for 4:2:0 video.
    rate : float
        Frames per second.
    crf : int
        x264's quality, 18 by default; 0 is lossless RGB.
    preset : str
        How long x264 looks for smaller files.
    uneven : bool
        Whether frames are shown at times of their own, exactly, and not at steps of 1 / `rate`.
    quick : bool
        Whether 4:2:0 video takes its chroma from one pixel of four, and `crf` is a constant
        quantiser (x264's `qp`): that takes a third and two thirds of the time.
    """

    def __init__(
        self,
        path: Path,
        size: tuple[int, int],
        rate: float,
        crf: int = 18,
        preset: str = "veryfast",
        uneven: bool = False,
        quick: bool = False,
    ) -> None:
        self._container = av.open(str(path), "w")
        codec = "libx264rgb" if crf == 0 else "libx264"
        step = (
            1 / Fraction(rate).limit_denominator(1000)
            if rate > _SLOW
            else Fraction(round(1 / rate))
        )
        stream = cast(
            "av.VideoStream",  # PyAV's types know few codecs by their names
            self._container.add_stream(codec, rate=1 / step),
        )
        even = 1 if crf == 0 else 2
        self._size = size[0] // even * even, size[1] // even * even
        stream.width, stream.height = self._size
        stream.pix_fmt = "rgb24" if crf == 0 else "yuv420p"
        # With several threads, or the kernels that suit one machine best, x264 does not
        # always write the same bytes for the same pictures.
        told = "threads=1:lookahead-threads=1:asm=sse4.2"
        if quick:
            told += f":qp={crf}"
        if uneven:  # frames out of order would end an MP4 too early
            told += ":bframes=0"
        stream.options = {"crf": str(crf), "preset": preset, "x264-params": told}
        self._stream, self._quick = stream, quick and crf > 0
        self._time_base = _CLOCK if uneven else step
        self._ticks = max(1, round(step / self._time_base))
        if uneven:
            stream.codec_context.time_base = _CLOCK
        self._last = -self._ticks

    def write(self, frame: Frame, time: float | None = None) -> None:
        """Append one frame, (H, W, 3) uint8 RGB; shown at `time`, s, if that is later.

        Unless frames are uneven, that is the nearest step of 1 / `rate`; without a time, the next.
        """
        cut = np.ascontiguousarray(frame[: self._size[1], : self._size[0]])
        picture = self._picture(cut)
        due = self._last + self._ticks if time is None else round(time / self._time_base)
        self._last = max(self._last + 1, due)
        picture.pts, picture.time_base = self._last, self._time_base
        self._container.mux(self._stream.encode(picture))

    def _picture(self, frame: Frame) -> av.VideoFrame:
        """The frame as it is encoded."""
        if not self._quick:
            return av.VideoFrame.from_ndarray(frame, format="rgb24")
        planes = np.asarray(cv2.cvtColor(frame, cv2.COLOR_RGB2YUV_I420), np.uint8)
        return av.VideoFrame.from_ndarray(planes, format="yuv420p")

    def close(self) -> None:
        """Flush and close the file."""
        self._container.mux(self._stream.encode())
        self._container.close()

    def __enter__(self) -> VideoWriter:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def film_bytes(
    frames: Iterable[Frame], rate: float, crf: int = 18, times: FloatArray | None = None
) -> bytes:
    """Frames of one size as an MP4, shown at even steps or at the `times` (T,), s, since the first.

    Raises
    ------
    OutputError
        If temporary files cannot be written.
    """
    with scratch() as folder:
        path = folder / "film.mp4"
        with ExitStack() as stack:
            writer: VideoWriter | None = None
            for number, frame in enumerate(frames):
                if writer is None:
                    size = frame.shape[1], frame.shape[0]
                    made = VideoWriter(path, size, rate, crf, uneven=times is not None)
                    writer = stack.enter_context(made)
                writer.write(frame, None if times is None else float(times[number] - times[0]))
        return path.read_bytes()
