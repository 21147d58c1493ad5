"""Reads a video behind a URL as it comes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import av
import av.error

from abs_engine.core.errors import VideoError
from abs_engine.core.words import counted
from abs_engine.io.video.ending import Ending
from abs_engine.io.video.reader import Decoder
from abs_engine.io.video.shown import Harmless, Pictures, Turn, pixel_aspect
from abs_engine.io.video.source import open_url, picture_stream, reason
from abs_engine.io.video.writer import Frame

_PATIENCE = 30.0  # seconds; segments of a live stream may last ten


def open_stream(url: str) -> tuple[float, bool, Iterator[tuple[Frame, float | None]]]:
    """A video behind a URL: its rate, whether it is recorded, and its frames, which close the URL.

    Frames per second are as stated, 0 where it does not say. What does not say how long it is, is
    live. Each frame is as `read_frames` gives it, with its time, seconds.

    Raises
    ------
    VideoError
        If it cannot be opened, or, as frames come, if it breaks off.
    """
    container = open_url(url, _PATIENCE)
    stream = picture_stream(container)
    rate = float(stream.guessed_rate or stream.average_rate or 0)
    return rate, bool(container.duration), _frames(url, container, stream)


def _frames(
    url: str, container: av.container.InputContainer, stream: av.VideoStream
) -> Iterator[tuple[Frame, float | None]]:
    count, broken = 0, ""
    decoder, harmless, pictures = Decoder(stream), Harmless(), Pictures()
    ending, aspect = Ending(Path(url), container, stream), pixel_aspect(stream)

    def packets() -> Iterator[av.Packet[Any]]:
        """Each packet, and at the end an empty one, with which the decoder gives its last frames.

        Where a server says no length, FFmpeg takes even the end of a whole file for an error.
        """
        nonlocal broken
        try:
            yield from container.demux()
        except av.error.FFmpegError as error:
            broken = reason(error)
            last: av.Packet[Any] = av.Packet()
            last.stream = stream
            yield last

    with container:
        for packet in packets():
            ending.packet(packet)
            for frame in decoder.frames(packet):
                yield pictures.shown(frame, aspect, Turn.of(frame, harmless)), frame.time
                count += 1
        why = broken if ending.short() is None else ending.short()
    if why:
        said = f"{url} breaks off after {counted(count, 'frame')} ({why})"
        raise VideoError(said, "check what sends it")
