"""Pictures as they are shown: upright, and with square pixels."""

from __future__ import annotations

import av
import cv2
import numpy as np

from abs_engine.io.video.writer import Frame

_SQUARE = 0.01  # pixels that are so nearly square are
_LONGEST = 3.0  # a longer pixel is a mistake in the file


def pixel_aspect(stream: av.VideoStream) -> float:
    """Width of a stream's coded pixels over their height; 1 where the file does not say."""
    stated = float(stream.sample_aspect_ratio or 0) or 1.0
    believed = 1 / _LONGEST <= stated <= _LONGEST and abs(stated - 1) >= _SQUARE
    return stated if believed else 1.0


def shown_size(frame: av.VideoFrame, aspect: float) -> tuple[int, int]:
    """Height and width of a frame as shown: stretched along the longer side of its pixels."""
    height, width = _stretched(frame, aspect)
    return (height, width) if _quarter_turns(frame) % 2 == 0 else (width, height)


def shown(frame: av.VideoFrame, aspect: float) -> Frame:
    """A frame as shown, (H, W, 3) uint8 RGB; no row or column of what was coded is left out."""
    picture = frame.to_ndarray(format="rgb24")
    height, width = _stretched(frame, aspect)
    if picture.shape[:2] != (height, width):
        picture = np.asarray(cv2.resize(picture, (width, height)), np.uint8)
    return np.ascontiguousarray(np.rot90(picture, _quarter_turns(frame)), np.uint8)


def _stretched(frame: av.VideoFrame, aspect: float) -> tuple[int, int]:
    """Height and width with square pixels, before the frame is turned; even if it is stretched."""
    if aspect > 1:
        return frame.height, 2 * round(frame.width * aspect / 2)
    return (2 * round(frame.height / aspect / 2) if aspect < 1 else frame.height), frame.width


def _quarter_turns(frame: av.VideoFrame) -> int:
    """Counter-clockwise, as the file's display matrix has it."""
    return round(frame.rotation / 90) % 4
