"""Reads a video: what it is, and its frames."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import av
import av.error
import numpy as np

from abs_engine.core.errors import VideoError
from abs_engine.io.video.ending import Ending, broken_off
from abs_engine.io.video.source import open_video, picture_stream
from abs_engine.io.video.writer import Frame

_LONGEST_TAIL = 1000  # packets; with rarer key frames only `read_frames` judges the last frames


@dataclass(frozen=True)
class VideoInfo:
    """Properties of a video.

    Parameters
    ----------
    size : tuple of int
        Width and height in pixels, as shown: a phone's rotation is applied.
    rate : float
        Frames per second, on average.
    frames : int
        Number of coded frames.
    times : tuple of float
        When each frame is shown, seconds from the first; empty where the file does not say.
    """

    size: tuple[int, int]
    rate: float
    frames: int
    times: tuple[float, ...] = ()


def probe(path: Path) -> VideoInfo:
    """Size, rate, number and times of the frames; the whole file is read, hardly any is decoded.

    Raises
    ------
    InputFileError
        If the file is missing, empty, a folder, or may not be read.
    VideoError
        If it is not a video, holds no frame, or breaks off.
    """
    first = _first_frame(path)
    with open_video(path) as container:
        stream = picture_stream(container)
        times, count = _survey(path, container, stream)
        guessed = float(stream.average_rate or stream.guessed_rate or 0)
    height, width = _size(first)
    return VideoInfo((width, height), _rate(times, guessed), count, times)


def read_frames(path: Path) -> Iterator[Frame]:
    """Frames in order, upright, (H, W, 3) uint8 RGB.

    Raises
    ------
    InputFileError
        If the file is missing, empty, a folder, or may not be read.
    VideoError
        If it is not a video, holds no frame, changes its size, or breaks off; the message tells
        after how many frames.
    """
    size = None
    for count, frame in enumerate(_decoded(path)):
        size = size or _size(frame)
        if _size(frame) != size:
            raise VideoError(
                f"{path} changes its size after {count} frames", "export it at one size"
            )
        turned = np.rot90(frame.to_ndarray(format="rgb24"), _quarter_turns(frame))
        yield np.ascontiguousarray(turned, np.uint8)


def _decoded(path: Path) -> Iterator[av.VideoFrame]:
    """All frames; complains at the end if it was none."""
    count = 0
    with open_video(path) as container:
        stream = picture_stream(container)
        ending = Ending(path, container, stream)
        try:
            for packet in container.demux():
                ending.packet(packet)
                for frame in _frames_of(packet, stream, count == 0):
                    ending.frame(frame)
                    yield frame
                    count += 1
        except av.error.FFmpegError as error:
            raise broken_off(path, count, f" ({error.strerror})") from error
        ending.check(count)
    if count == 0:
        raise VideoError(f"{path} holds no frames", "check that it is whole")


def _frames_of(
    packet: av.Packet[Any], stream: av.VideoStream, beginning: bool
) -> list[av.VideoFrame]:
    """The frames that come with a packet.

    A recording may begin between two key frames: what comes before the first cannot be decoded.
    """
    if packet.stream is not stream:
        return []
    try:
        return list(stream.decode(packet))
    except av.error.InvalidDataError:
        if beginning:
            return []
        raise


def _first_frame(path: Path) -> av.VideoFrame:
    frames = _decoded(path)
    try:
        return next(frames)
    except StopIteration:
        raise VideoError(f"{path} holds no frames", "check that it is whole") from None
    finally:
        frames.close()  # type: ignore[attr-defined]


def _survey(
    path: Path, container: av.container.InputContainer, stream: av.VideoStream
) -> tuple[tuple[float, ...], int]:
    """Times and number of the coded frames; complains if the file breaks off.

    Only the last two groups of pictures are decoded: the first frames of a group may lean on the
    group before.
    """
    ending = Ending(path, container, stream)
    stamps: list[int | None] = []
    before: list[av.Packet[Any]] = []
    last: list[av.Packet[Any]] = []
    try:
        for packet in container.demux():
            ending.packet(packet)
            if packet.stream is not stream:
                continue
            if packet.is_keyframe and packet.size:
                before, last = last, []
            if len(last) <= _LONGEST_TAIL:
                last.append(packet)
            if packet.size:
                stamps.append(packet.pts)
        tail = before + last if len(before + last) <= _LONGEST_TAIL else []
        for packet in tail:
            for frame in stream.decode(packet):
                ending.frame(frame)
    except av.error.FFmpegError as error:
        raise broken_off(path, len(stamps), f" ({error.strerror})") from error
    ending.check(len(stamps))
    known = sorted(stamp for stamp in stamps if stamp is not None)
    if len(known) < len(stamps) or len(set(known)) < len(known) or stream.time_base is None:
        return (), len(stamps)
    return tuple(float((stamp - known[0]) * stream.time_base) for stamp in known), len(stamps)


def _rate(times: tuple[float, ...], stated: float) -> float:
    """Frames per second: what the file states, unless its own times tell otherwise."""
    if len(times) < 2:
        return stated or 25.0
    measured = (len(times) - 1) / times[-1]
    return stated if stated and abs(stated / measured - 1) < 0.02 else measured


def _quarter_turns(frame: av.VideoFrame) -> int:
    """Counter-clockwise, as the file's display matrix has it."""
    return round(frame.rotation / 90) % 4


def _size(frame: av.VideoFrame) -> tuple[int, int]:
    """Height and width of the frame as shown."""
    size = frame.height, frame.width
    return size if _quarter_turns(frame) % 2 == 0 else size[::-1]
