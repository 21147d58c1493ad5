"""The window of a picture about part of a head, and at which size a camera shows it."""

from __future__ import annotations

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera, Window
from abs_engine.core.geometry import Pose
from abs_engine.tracking.settings.head import HEAD_POSE

_LEAST = 8.0  # px


def pixels_a_mm(pose: Pose, camera: Camera) -> float:
    """Size at which a camera shows a head."""
    return float(camera.matrix[0, 0] / pose.translation[2])


def window_about(vertices: FloatArray, pose: Pose, camera: Camera, side: int) -> Window:
    """About vertices (N, 3), mm, head frame; its longer side is `side` drawn pixels at most."""
    pixels = camera.project(pose.apply(vertices))
    low, high = pixels.min(axis=0) - HEAD_POSE.margin, pixels.max(axis=0) + HEAD_POSE.margin
    size = np.clip(high - low, _LEAST, 4.0 * max(camera.size))
    scale = min(1.0, side / float(size.max()))
    return Window(float(low[0]), float(low[1]), float(size[0]), float(size[1]), scale)
