"""Reads a video: what it is, and its frames."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import av
import av.error

from abs_engine.core.errors import VideoError
from abs_engine.io.video.ending import Ending, broken_off
from abs_engine.io.video.shown import Harmless, Pictures, Turn, pixel_aspect, shown_size
from abs_engine.io.video.source import moving_streams, open_video, picture_stream
from abs_engine.io.video.writer import Frame

_NOT_WHOLE = "check that it is whole, or convert it to MP4"
_LONGEST_TAIL = 1000  # packets; with rarer key frames only `read_frames` judges the last frames

_VP8_SHOWN = 0x10  # of the first byte of a packet
_TIMELESS = 0x80  # AVFMT_NOTIMESTAMPS of FFmpeg's libavformat/avformat.h; PyAV types it wrongly


@dataclass(frozen=True)
class VideoInfo:
    """Properties of a video.

    Parameters
    ----------
    size : tuple of int
        Width and height in square pixels, as shown: turned and mirrored as the file says.
    rate : float
        Frames per second, on average.
    frames : int
        Number of frames that are shown.
    times : tuple of float
        When each frame is shown, seconds from the first; empty where the file does not say.
    interlaced : bool
        Whether the first frame is marked as two fields, taken one after the other.
    sound : float
        When the sound begins, seconds from the first frame; 0 without sound, or where the file does
        not say.
    askew : bool
        Whether the file asks for a rotation that is not a multiple of 90 degrees.
    clock : str
        What `rate` rests on: "file"; or, where the file holds no times or only one, as raw streams
        do, "stream", the rate that its stream states, or "nothing", 25 for want of one.
    streams : int
        Number of videos in the file; one is read, see `picture_stream`.
    """

    size: tuple[int, int]
    rate: float
    frames: int
    times: tuple[float, ...] = ()
    interlaced: bool = False
    sound: float = 0.0
    askew: bool = False
    clock: str = "file"
    streams: int = 1


def probe(path: Path) -> VideoInfo:
    """Size, rate, number and times of the frames; the whole file is read, hardly any is decoded.

    Raises
    ------
    InputFileError
        If the file is missing, empty, a folder, or may not be read.
    VideoError
        If it is not a video, holds no frame, or breaks off.
    """
    with closing(_decoded(path)) as frames:  # which complains if there are none
        first, aspect = next(frames)
    turn = Turn.of(first, Harmless())
    height, width = shown_size(first, aspect, turn)
    with open_video(path) as container:
        stream = picture_stream(container)
        begins, times, count, still = _survey(path, container, stream, first.pts)
        stated = float(stream.average_rate or stream.guessed_rate or 0)
        clock = "file"
        if still or container.format.flags & _TIMELESS:  # what there is, FFmpeg made up
            stated = float(stream.codec_context.framerate or 0)
            begins, times, clock = None, (), "stream" if stated else "nothing"
        sound, streams = _sound(container, begins), len(moving_streams(container))
    return VideoInfo(
        size=(width, height),
        rate=_rate(times, stated),
        frames=count,
        times=times,
        interlaced=first.interlaced_frame,
        sound=sound,
        askew=turn.askew,
        clock=clock,
        streams=streams,
    )


def read_frames(path: Path) -> Iterator[Frame]:
    """Frames in order, upright, in square pixels, (H, W, 3) uint8 RGB.

    Raises
    ------
    InputFileError
        If the file is missing, empty, a folder, or may not be read.
    VideoError
        If it is not a video, holds no frame, changes its size, or breaks off; the message tells
        after how many frames.
    """
    size, harmless, pictures = None, Harmless(), Pictures()
    for count, (frame, aspect) in enumerate(_decoded(path)):
        turn = Turn.of(frame, harmless)
        size = size or shown_size(frame, aspect, turn)
        if shown_size(frame, aspect, turn) != size:
            raise VideoError(
                f"{path} changes its size after {count} frames", "export it at one size"
            )
        yield pictures.shown(frame, aspect, turn)


def _decoded(path: Path) -> Generator[tuple[av.VideoFrame, float]]:
    """All frames, and the aspect of their pixels; complains at the end if it was none."""
    count = 0
    with open_video(path) as container:
        stream = picture_stream(container)
        aspect, ending = pixel_aspect(stream), Ending(path, container, stream)
        decoder = Decoder(stream)
        try:
            for packet in container.demux():
                ending.packet(packet)
                for frame in decoder.frames(packet):
                    ending.frame(frame)
                    yield frame, aspect
                    count += 1
            decoder.check()
        except av.error.FFmpegError as error:
            raise broken_off(path, count, f" ({error.strerror})") from error
        ending.check(count)
    if count == 0:
        raise VideoError(f"{path} holds no frames", _NOT_WHOLE)


class Decoder:
    """Decodes a stream's packets; those that are damaged cost their frames, unless they end it."""

    def __init__(self, stream: av.VideoStream) -> None:
        self._stream, self._begun = stream, False
        self._damage: av.error.InvalidDataError | None = None

    def frames(self, packet: av.Packet[Any]) -> list[av.VideoFrame]:
        """The frames that come with a packet, of whatever stream.

        A recording may begin between two key frames: what comes before the first cannot be decoded.
        """
        if packet.stream is not self._stream:
            return []
        try:
            found = list(self._stream.decode(packet))
        except av.error.InvalidDataError as error:
            self._damage = error if self._begun else None
            return []
        if packet.size:  # the last one, which is empty, gives frames of earlier packets
            self._damage = None
        self._begun |= bool(found)
        return found

    def check(self) -> None:
        """Raise what was wrong with the last packets, if anything."""
        if self._damage is not None:
            raise self._damage


def _survey(
    path: Path, container: av.container.InputContainer, stream: av.VideoStream, first: int | None
) -> tuple[float | None, tuple[float, ...], int, bool]:
    """Time of the first frame shown, all times from it on, their number, and if all are one time.

    Complains if the file breaks off. Only the last two groups of pictures are decoded: the first
    frames of a group may lean on the group before. Of a recording that begins between two key
    frames, what would come before the `first` frame that can be shown, as stamped, is left out.
    """
    ending = Ending(path, container, stream)
    stamps: list[int | None] = []
    keys = 0
    before: list[av.Packet[Any]] = []
    last: list[av.Packet[Any]] = []
    try:
        for packet in container.demux():
            ending.packet(packet)
            if packet.stream is not stream:
                continue
            if packet.is_keyframe and packet.size:
                before, last, keys = last, [], keys + 1
            if len(last) <= _LONGEST_TAIL:
                last.append(packet)
            if _is_shown(packet, stream, first if keys < 2 else None):
                stamps.append(packet.pts)
        tail = before + last if len(before + last) <= _LONGEST_TAIL else []
        decoder = Decoder(stream)
        for packet in tail:
            for frame in decoder.frames(packet):
                ending.frame(frame)
        decoder.check()
    except av.error.FFmpegError as error:
        raise broken_off(path, len(stamps), f" ({error.strerror})") from error
    ending.check(len(stamps))
    known, unit = sorted(stamp for stamp in stamps if stamp is not None), stream.time_base
    if len(known) < len(stamps) or len(set(known)) < len(known) or unit is None:
        return None, (), len(stamps), len(set(known)) == 1
    times = tuple(float((stamp - known[0]) * unit) for stamp in known)
    return (float(known[0] * unit) if known else None), times, len(stamps), False


def _is_shown(packet: av.Packet[Any], stream: av.VideoStream, first: int | None) -> bool:
    """Whether a frame comes of a packet that somebody is shown: an edit list discards some.

    VP8 has packets whose picture others are made from and nobody sees (RFC 6386, section 9.1).
    """
    if not packet.size or packet.is_discard:
        return False
    if first is not None and packet.pts is not None and packet.pts < first:
        return False
    return stream.codec_context.name != "vp8" or bool(bytes(packet)[0] & _VP8_SHOWN)


def _rate(times: tuple[float, ...], stated: float) -> float:
    """Frames per second: what the file states, unless its own times tell otherwise."""
    if len(times) < 2:
        return stated or 25.0
    measured = (len(times) - 1) / times[-1]
    return stated if stated and abs(stated / measured - 1) < 0.02 else measured


def _sound(container: av.container.InputContainer, begins: float | None) -> float:
    """Beginning of the sound, seconds after `begins`; 0 where the file does not say."""
    for stream in container.streams.audio[:1]:
        if begins is not None and stream.start_time is not None and stream.time_base is not None:
            return float(stream.start_time * stream.time_base) - begins
    return 0.0
