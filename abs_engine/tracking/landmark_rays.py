"""Landmarks of a picture as rays of its camera."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.tracking.landmarks import Landmarks


@dataclass(frozen=True, eq=False)
class SeenRays:
    """Landmarks as rays of a camera.

    Parameters
    ----------
    rays : (468, 2) float64
        At depth 1.
    depth : (468,) float64
        Over the focal length.
    axes : (2, 2) float64
        Of the face, see `Landmarks.axes`.
    trust : (468,) float64
        Weight of each, 0 to 1.
    pixel : float
        Width of a pixel at depth 1.
    """

    rays: FloatArray
    depth: FloatArray
    axes: FloatArray
    trust: FloatArray
    pixel: float

    @classmethod
    def of(cls, landmarks: Landmarks, camera: Camera, trust: FloatArray | None = None) -> SeenRays:
        """The rays of landmarks in a camera's picture; by default all are trusted."""
        pixel = 1.0 / float(camera.matrix[0, 0])
        depth = landmarks.points[:, 2] * pixel
        weights = np.ones(len(depth)) if trust is None else trust
        rays = camera.undistort(landmarks.pixels)
        return cls(rays, depth, np.stack(landmarks.axes), weights, pixel)
