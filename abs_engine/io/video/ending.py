"""Tells a video that ends from one that breaks off."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from typing import Any

import av

from abs_engine.core.errors import VideoError
from abs_engine.core.words import counted
from abs_engine.io.video.truncation import is_torn

_LAST = 5  # packets and frames; a damaged frame may be shown a few frames before the last
_HEADED = ("matroska", "mov", "avi", "flv", "asf")
"""Containers whose headers state the duration; FFmpeg guesses it for the others."""

_SLACK = 0.25  # seconds that a header may promise too much


class Ending:
    """Watches packets and frames go by, and judges the end.

    A video breaks off if its container says that there is more (`is_torn`, the duration in its
    header), if a packet at its end came short, or if the decoder had to make up part of a frame
    at its end. Damage elsewhere is no break.
    """

    def __init__(
        self, path: Path, container: av.container.InputContainer, stream: av.VideoStream
    ) -> None:
        self._path, self._container, self._stream = Path(path), container, stream
        self._packets: deque[bool] = deque(maxlen=_LAST)
        self._frames: deque[bool] = deque(maxlen=_LAST)
        self._reached = 0.0

    def packet(self, packet: av.Packet[Any]) -> None:
        """See a packet of any stream."""
        if packet.size:
            self._packets.append(packet.is_corrupt)
        if packet.pts is not None and packet.time_base is not None:
            end = packet.pts + (packet.duration or 0)
            self._reached = max(self._reached, float(end * packet.time_base))

    def frame(self, frame: av.VideoFrame) -> None:
        """See a decoded frame."""
        self._frames.append(frame.is_corrupt)

    def check(self, count: int) -> None:
        """Raise `VideoError` if the end was no end; `count` frames came."""
        short = self.short() or ""
        if short or any(self._packets) or any(self._frames) or is_torn(self._path):
            raise broken_off(self._path, count, short and f", {short}")

    def short(self) -> str | None:
        """Place of an early end, as "at 1.0 of 2.0 s"; empty if whole, None if no header tells."""
        promised = self._promised()
        if promised <= 0:
            return None
        slack = max(_SLACK, 3 / float(self._stream.average_rate or 25))
        too_early = self._reached < promised - slack
        return f"at {self._reached:.1f} of {promised:.1f} s" if too_early else ""

    def _promised(self) -> float:
        """Seconds that the header promises; 0 where it says nothing."""
        if not any(name in self._container.format.name for name in _HEADED):
            return 0.0
        seconds = (self._container.duration or 0) / av.time_base
        if self._container.format.name == "avi" and self._stream.average_rate:
            # FFmpeg shortens an AVI's duration to what the file's size allows.
            seconds = max(seconds, float(self._stream.frames / self._stream.average_rate))
        return seconds


def broken_off(path: Path, count: int, why: str = "") -> VideoError:
    """The error of a video that ends too early."""
    after = counted(count, "frame")
    return VideoError(f"{path} is cut off after {after}{why}", "copy or export it again")
