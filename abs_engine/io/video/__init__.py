"""The only reader and writer of video (PyAV)."""

from __future__ import annotations

from abs_engine.io.video.reader import VideoInfo, probe, read_frames
from abs_engine.io.video.writer import Frame, VideoWriter, film_bytes

__all__ = ["Frame", "VideoInfo", "VideoWriter", "film_bytes", "probe", "read_frames"]
