"""Place of the mouth in a close-up, by the landmark network on a picture continued beyond it."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.face.appearance.opening import MouthSpot
from abs_engine.tracking.landmarks import landmarks_at
from abs_engine.tracking.settings.worn import CLOSE_UP

INNER = np.array([61, 291, 81, 178, 13, 14, 311, 402])
"""Landmarks of the corners and of the inner lips, in the order of `learn.opening.POINTS`."""


def mouth_points(image: Image, spot: MouthSpot | None = None) -> FloatArray:
    """Points (8, 2), px, of a mouth of whose face little more is in the picture (H, W, 3) RGB.

    The picture's border is repeated around it. Where it is not known where the mouth lies, it is
    looked for about the picture's middle, and each look begins where the one before ended.
    """
    height, width = image.shape[:2]
    margin = max(height, width)
    wide = cv2.copyMakeBorder(image, margin, margin, margin, margin, cv2.BORDER_REPLICATE)
    if spot is None:
        spot = MouthSpot((width - 1) / 2, (height - 1) / 2, CLOSE_UP.first_width * width)
    points = np.full((len(INNER), 2), np.nan)
    for _ in range(CLOSE_UP.looks):
        size = CLOSE_UP.face * spot.width
        centre = np.array([spot.x, spot.y - CLOSE_UP.below * size]) + margin
        seen = landmarks_at(np.asarray(wide, np.uint8), centre, size)
        if seen is None:
            break
        points = seen.pixels[INNER] - margin
        spot = MouthSpot.between(points[0], points[1])
    return points


def unsettled(images: Sequence[Image]) -> float:
    """Standard deviation of the logarithm of a mouth's width by where it is first looked for.

    The network sees a mouth in anything. Where there is one, each look ends at it, wherever it
    began; elsewhere they end here and there. That of the median frame; infinite where it sees none.
    """
    return float(np.median([_spread_of_widths(image) for image in images]))


def _spread_of_widths(image: Image) -> float:
    height, width = image.shape[:2]
    widths = []
    for right, down, factor in CLOSE_UP.starts:
        x, y = (0.5 + right) * (width - 1), (0.5 + down) * (height - 1)
        points = mouth_points(image, MouthSpot(x, y, factor * CLOSE_UP.first_width * width))
        widths.append(float(np.linalg.norm(points[1] - points[0])))
    sound = np.isfinite(widths).all() and min(widths) > 0
    return float(np.std(np.log(widths))) if sound else float("inf")


def find_mouth(images: Sequence[Image]) -> tuple[MouthSpot, list[FloatArray]]:
    """Place of the mouth in several frames of a clip, and points (8, 2) of it in each."""
    first = [mouth_points(image) for image in images]
    left, right = np.median(np.stack(first)[:, :2], axis=0)
    spot = MouthSpot.between(left, right)
    return spot, [mouth_points(image, spot) for image in images]
