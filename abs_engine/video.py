"""The only reader and writer of video (PyAV)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import cast

import av
import av.error
import numpy as np
from numpy.typing import NDArray

from abs_engine.errors import InputFileError, VideoError

Frame = NDArray[np.uint8]


@dataclass(frozen=True)
class VideoInfo:
    """What a video is, as far as its container says.

    Parameters
    ----------
    size : tuple of int
        Width and height in pixels.
    rate : float
        Frames per second.
    frames : int
        Number of frames; 0 where the container does not say.
    """

    size: tuple[int, int]
    rate: float
    frames: int


def probe(path: Path) -> VideoInfo:
    """Size, rate and (estimated) number of frames.

    Raises
    ------
    InputFileError
        If the file is missing or empty.
    VideoError
        If it is not a video.
    """
    with _open(path) as container:
        stream = container.streams.video[0]
        rate = float(stream.average_rate or stream.guessed_rate or 25)
        frames = stream.frames
        if not frames and stream.duration and stream.time_base:
            frames = round(float(stream.duration * stream.time_base) * rate)
        return VideoInfo((stream.codec_context.width, stream.codec_context.height), rate, frames)


def read_frames(path: Path) -> Iterator[Frame]:
    """Frames in order, (H, W, 3) uint8 RGB.

    Raises
    ------
    InputFileError
        If the file is missing or empty.
    VideoError
        If it is not a video, holds no frame, or breaks off; the message tells after how many.
    """
    count = 0
    with _open(path) as container:
        try:
            for frame in container.decode(video=0):
                yield np.asarray(frame.to_ndarray(format="rgb24"), np.uint8)
                count += 1
        except av.error.FFmpegError as error:
            raise VideoError(
                f"{path} breaks off after {count} frames ({error.strerror})",
                "copy or export the video again",
            ) from error
        promised = _promised(container)
    if count == 0:
        raise VideoError(f"{path} holds no frames", "check that it is whole")
    if promised and count < 0.9 * promised - 2:
        raise VideoError(
            f"{path} breaks off after {count} of {promised} frames", "copy or export it again"
        )


def _promised(container: av.container.InputContainer) -> int:
    """The number of frames that the file's header promises; 0 where it says nothing."""
    stream = container.streams.video[0]
    if stream.frames:
        return int(stream.frames)
    rate = float(stream.average_rate or 0)
    return int(rate * (container.duration or 0) / av.time_base)


def _open(path: Path) -> av.container.InputContainer:
    path = Path(path)
    if not path.is_file():
        raise InputFileError(f"{path} does not exist", "check the path of the video")
    if path.stat().st_size == 0:
        raise InputFileError(f"{path} is empty", "copy or export the video again")
    try:
        container = av.open(str(path))
    except av.error.FFmpegError as error:
        raise VideoError(f"{path} is not a video", "give MP4, AVI, MPEG, MKV or WebM") from error
    if not container.streams.video:
        container.close()
        raise VideoError(f"{path} has no video stream", "give a file with pictures")
    return container


class VideoWriter:
    """Writes H.264 in MP4, for people to look at or, with `crf` 0, without loss in RGB.

    Parameters
    ----------
    path : Path
    size : tuple of int
        Width and height in pixels; odd sizes are cut by one for 4:2:0 video.
    rate : float
        Frames per second.
    crf : int
        x264's quality, 18 by default; 0 is lossless RGB.
    """

    def __init__(self, path: Path, size: tuple[int, int], rate: float, crf: int = 18) -> None:
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
        stream.options = {"crf": str(crf), "preset": "veryfast"}
        self._stream = stream

    def write(self, frame: Frame) -> None:
        """Append one frame, (H, W, 3) uint8 RGB."""
        cut = np.ascontiguousarray(frame[: self._size[1], : self._size[0]])
        picture = av.VideoFrame.from_ndarray(cut, format="rgb24")
        self._container.mux(self._stream.encode(picture))

    def close(self) -> None:
        """Flush and close the file."""
        self._container.mux(self._stream.encode())
        self._container.close()

    def __enter__(self) -> VideoWriter:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
