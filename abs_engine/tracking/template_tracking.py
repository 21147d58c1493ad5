"""Template tracking: a head whose points were lost, by the look of its upper face."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import Image
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.tracking.settings.detection import DETECTION


def carried(
    before: Image, pose: Pose, now: Image, points: NDArray[np.floating], camera: Camera
) -> Pose | None:
    """A head's pose, moved across the line of sight as its face moved from one frame to the next.

    Found by normalised correlation of the face as a whole, for which few details are enough.
    `points` (N, 3), mm, head frame, are of its rigid part. None where the next frame's face does
    not look as before: nearer, turned, or another one.
    """
    if before.shape != now.shape:
        return None
    there = pose.apply(points.astype(np.float64))
    pixels, depth = camera.project(there), float(there[:, 2].mean())
    focal = camera.matrix[0, 0]
    limits = np.array(before.shape[1::-1]) - 1
    low, high = (np.clip(np.rint(f(pixels, axis=0)), 0, limits) for f in (np.min, np.max))
    size = high - low
    if size.min() < DETECTION.least_template:
        return None
    scale = min(1.0, DETECTION.most_template / size.max())
    reach = DETECTION.reach * focal / depth
    first = np.maximum(low - reach, 0).astype(int)
    last = np.minimum(high + reach, limits).astype(int)
    face = _small(before, low.astype(int), high.astype(int), scale)
    around = _small(now, first, last, scale)
    if float(face.std()) < 1.0:
        return None
    match = cv2.matchTemplate(around, face, cv2.TM_CCOEFF_NORMED)
    _, best, _, at = cv2.minMaxLoc(match)
    if best < DETECTION.alike:
        return None
    move = (np.array(at) / scale + first - low) * depth / focal
    return Pose(pose.rotation, pose.translation + np.r_[move, 0.0])


def _small(image: Image, low: NDArray[np.int_], high: NDArray[np.int_], scale: float) -> Image:
    part = cv2.cvtColor(image[low[1] : high[1] + 1, low[0] : high[0] + 1], cv2.COLOR_RGB2GRAY)
    return np.asarray(
        cv2.resize(part, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), np.uint8
    )
