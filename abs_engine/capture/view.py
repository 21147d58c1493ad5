"""A view of the world: a camera, where it stands, and perhaps a mirror that it looks into."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import Pose

_HERE = Pose(np.eye(3), np.zeros(3))


@dataclass(frozen=True, eq=False)
class Plane:
    """The plane of a mirror, n . x + distance = 0, which reflects to the side that n points to.

    Parameters
    ----------
    normal : (3,) float64, camera frame
        Made a unit vector that points to the camera's side.
    distance : float
        Of the camera from the plane, mm, above zero.

    Raises
    ------
    ParameterError
        If the normal is no direction, or the camera stands in the plane.
    """

    normal: FloatArray
    distance: float

    def __post_init__(self) -> None:
        normal = np.asarray(self.normal, np.float64).reshape(3)
        length = float(np.linalg.norm(normal))
        if not np.isfinite(length) or not np.isfinite(self.distance) or length == 0:
            raise ParameterError("the mirror has no normal", "calibrate the mirror again")
        if self.distance == 0:
            raise ParameterError("the camera stands in the mirror's plane", "turn the mirror")
        towards = np.sign(self.distance)
        object.__setattr__(self, "normal", towards * normal / length)
        object.__setattr__(self, "distance", abs(float(self.distance)) / length)

    @classmethod
    def through(cls, corners: ArrayLike) -> Plane:
        """The plane through three or more points (N, 3), mm, camera frame."""
        points = np.asarray(corners, np.float64).reshape(-1, 3)
        centre = points.mean(axis=0)
        normal = np.linalg.svd(points - centre)[2][2]
        return cls(normal, float(-normal @ centre))

    @property
    def matrix(self) -> FloatArray:
        """Linear part (3, 3) of the reflection."""
        return np.asarray(np.eye(3) - 2 * np.outer(self.normal, self.normal))

    def height(self, points: FloatArray) -> FloatArray:
        """Distances (...) of points (..., 3), mm, camera frame, before the mirror; < 0: behind."""
        return np.asarray(points @ self.normal + self.distance)

    def reflect(self, points: FloatArray) -> FloatArray:
        """Mirror images (..., 3) of points (..., 3), mm, camera frame."""
        return np.asarray(points - 2 * self.height(points)[..., None] * self.normal)


@dataclass(frozen=True, eq=False)
class View:
    """Projection of world points: x_cam = R x + t, reflected where a mirror is looked into.

    Parameters
    ----------
    pose : Pose
        World to camera; by default the world is the camera's own frame.
    mirror : Plane, optional
        The view is the one that the mirror gives: that of the virtual camera behind it.
    """

    camera: Camera
    pose: Pose = field(default_factory=lambda: _HERE)
    mirror: Plane | None = None

    @property
    def motion(self) -> tuple[FloatArray, FloatArray]:
        """A (3, 3) and b (3,) mm of x_seen = A x + b; A turns handedness over in a mirror."""
        if self.mirror is None:
            return self.pose.rotation, self.pose.translation
        return self.mirror.matrix @ self.pose.rotation, self.mirror.reflect(self.pose.translation)

    def seen(self, points: FloatArray) -> FloatArray:
        """World points (..., 3) in the frame of the camera, reflected where there is a mirror."""
        linear, offset = self.motion
        return np.asarray(points @ linear.T + offset)

    def project(self, points: FloatArray) -> FloatArray:
        """Pixels (..., 2) of world points (..., 3), mm."""
        return self.camera.project(self.seen(points))

    def directions(self, pixels: FloatArray) -> FloatArray:
        """Unit vectors (..., 3), world frame, in which pixels (..., 2) look."""
        ideal = self.camera.undistort(pixels)
        sight = np.concatenate([ideal, np.ones((*ideal.shape[:-1], 1))], axis=-1)
        along = sight @ self.motion[0]
        return np.asarray(along / np.linalg.norm(along, axis=-1, keepdims=True))
