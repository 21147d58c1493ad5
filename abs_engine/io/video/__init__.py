"""The only reader and writer of video (PyAV)."""

from __future__ import annotations

from abs_engine.io.video.reader import VideoInfo, probe, read_frames
from abs_engine.io.video.writer import Frame, VideoWriter

__all__ = ["Frame", "VideoInfo", "VideoWriter", "probe", "read_frames"]
