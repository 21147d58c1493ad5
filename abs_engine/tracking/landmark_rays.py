"""Landmarks of a picture as rays of its camera."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.tracking.landmarks import Landmarks


@dataclass(frozen=True, eq=False)
class SeenRays:
    """Landmarks as rays (468, 2) at depth 1, their depth in pixels, and the face's axes."""

    rays: FloatArray
    depth: FloatArray
    axes: FloatArray

    @classmethod
    def of(cls, landmarks: Landmarks, camera: Camera) -> SeenRays:
        """The rays of landmarks in a camera's picture."""
        flat = cv2.undistortPoints(landmarks.pixels[:, None], camera.matrix, camera.distortion)
        depth = landmarks.points[:, 2] / camera.matrix[0, 0]
        return cls(np.asarray(flat[:, 0], np.float64), depth, np.stack(landmarks.axes))
