"""Lines, dots and arrows on pictures, drawn at fractions of a pixel, in place."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, Image

Colour = tuple[int, int, int]
_BITS = 4  # of OpenCV's sub-pixel coordinates
_VISIBLE = 1.5  # pixels: shorter arrows are dots
_HEAD = 4.0  # pixels


def draw_line(
    picture: Image, points: FloatArray, closed: bool, colour: Colour, width: int = 1
) -> None:
    """A smooth line through pixels (N, 2), which returns to its beginning if it is closed."""
    cv2.polylines(picture, [_fixed(points)], closed, colour, width, cv2.LINE_AA, _BITS)


def draw_circles(
    picture: Image, points: FloatArray, radius: float, colour: Colour, width: int = -1
) -> None:
    """Circles around pixels (N, 2), of lines of a width; by default discs."""
    for place in _fixed(points).tolist():
        cv2.circle(picture, place, round(radius * 2**_BITS), colour, width, cv2.LINE_AA, _BITS)


def draw_arrows(picture: Image, begin: FloatArray, end: FloatArray, colour: Colour) -> None:
    """Arrows from pixels `begin` (N, 2), which are dots, to pixels `end` (N, 2)."""
    lengths = np.linalg.norm(end - begin, axis=1)
    ends = zip(_fixed(begin).tolist(), _fixed(end).tolist(), lengths.tolist(), strict=True)
    for first, last, length in ends:
        if length > _VISIBLE:
            tip = min(0.5, _HEAD / length)
            cv2.arrowedLine(picture, first, last, colour, 1, cv2.LINE_AA, _BITS, tip)
    draw_circles(picture, begin, 1.2, colour)


def _fixed(points: FloatArray) -> NDArray[np.int32]:
    return np.asarray(np.rint(points * 2**_BITS), np.int32)
