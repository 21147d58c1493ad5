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


class Stream:
    """A video behind a URL, opened.

    Attributes
    ----------
    rate : float
        Frames per second, as stated; 0 where it does not say.
    recorded : bool
        Whether it says how long it is; else it is live.

    Raises
    ------
    VideoError
        If it cannot be opened.
    """

    def __init__(self, url: str) -> None:
        self._url, self._broken, self._container = url, "", open_url(url, _PATIENCE)
        self._stream = picture_stream(self._container)
        self.rate = float(self._stream.guessed_rate or self._stream.average_rate or 0)
        self.recorded = bool(self._container.duration)

    def frames(self) -> Iterator[tuple[Frame, float | None]]:
        """Each frame as `read_frames` gives it, and its time, seconds; closes the URL at the end.

        Raises
        ------
        VideoError
            If it breaks off.
        """
        count, decoder, harmless, pictures = 0, Decoder(self._stream), Harmless(), Pictures()
        ending = Ending(Path(self._url), self._container, self._stream)
        aspect = pixel_aspect(self._stream)
        with self._container:
            for packet in self._packets():
                ending.packet(packet)
                for frame in decoder.frames(packet):
                    yield pictures.shown(frame, aspect, Turn.of(frame, harmless)), frame.time
                    count += 1
            why = self._broken if ending.short() is None else ending.short()
        if why:
            said = f"{self._url} breaks off after {counted(count, 'frame')} ({why})"
            raise VideoError(said, "check what sends it")

    def _packets(self) -> Iterator[av.Packet[Any]]:
        """Each packet, and at the end an empty one, with which the decoder gives its last frames.

        Where a server says no length, FFmpeg takes even the end of a whole file for an error.
        """
        try:
            yield from self._container.demux()
        except av.error.FFmpegError as error:
            self._broken = reason(error)
            last: av.Packet[Any] = av.Packet()
            last.stream = self._stream
            yield last
