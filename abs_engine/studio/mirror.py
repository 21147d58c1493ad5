"""A flat mirror in front of the camera: a second view of the head in the same picture.

What is seen in a mirror is the reflected world, seen through the mirror's rectangle. So the head is
drawn twice: as it is, and with reflected vertices and facets wound the other way round, which is
kept only where a pixel's line of sight passes through the rectangle. Of other things only what is
before the mirror's plane is reflected.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError

_SMALLEST = 1.0
"""Sides shorter than this (mm) make no mirror."""
_SHINE = 0.9
"""Share of the light that the mirror gives back."""
_SKEW = 0.01
"""Corners may be off a true rectangle by this share of its diagonal."""
_SIGHT_STEPS = 30
"""Fixed-point steps that undo the lens distortion."""


@dataclass(frozen=True, eq=False)
class Mirror:
    """A rectangular mirror that stands still in a camera's frame.

    Parameters
    ----------
    corners : (4, 3) float64, mm, camera frame (OpenCV: x right, y down, z forward)
        In order around the rectangle, either way round. The side that faces the camera reflects.

    Raises
    ------
    ParameterError
        If they make no rectangle, the camera sees the mirror from its edge, or a corner is not in
        front of the camera.
    """

    corners: FloatArray

    def __post_init__(self) -> None:
        corners = np.array(self.corners, np.float64)
        object.__setattr__(self, "corners", corners)
        if corners.shape != (4, 3) or not np.isfinite(corners).all():
            raise ParameterError(
                f"the mirror's corners have shape {corners.shape}", "give four finite points"
            )
        _check_rectangle(corners)
        if corners[:, 2].min() <= 0:
            raise ParameterError(
                "a corner of the mirror is not in front of the camera", "give corners with z > 0"
            )
        if self.distance < _SKEW * np.linalg.norm(corners, axis=1).max():
            raise ParameterError(
                "the camera sees the mirror from its edge", "turn the mirror towards the camera"
            )

    @classmethod
    def standing(
        cls, centre: tuple[float, float, float], yaw: float, size: tuple[float, float]
    ) -> Mirror:
        """A mirror with level upper and lower edges.

        Parameters
        ----------
        centre : tuple of float, mm, camera frame
        yaw : float
            Radians by which it is turned about the vertical from facing the camera's plane; above
            zero its left edge comes nearer.
        size : tuple of float
            Width and height, mm.
        """
        across = np.array([np.cos(yaw), 0.0, np.sin(yaw)]) * size[0] / 2
        down = np.array([0.0, size[1] / 2, 0.0])
        signs = ((-1, -1), (1, -1), (1, 1), (-1, 1))
        return cls(np.array([np.asarray(centre) + a * across + d * down for a, d in signs]))

    @cached_property
    def normal(self) -> FloatArray:
        """Unit normal (3,) float64 of the reflecting side, camera frame."""
        n = np.cross(self.corners[1] - self.corners[0], self.corners[3] - self.corners[0])
        n /= np.linalg.norm(n)
        return np.asarray(-n if n @ self.corners[0] > 0 else n, np.float64)

    @cached_property
    def distance(self) -> float:
        """Distance of the camera from the mirror's plane, mm; above zero."""
        return float(-self.normal @ self.corners.mean(axis=0))

    @cached_property
    def matrix(self) -> FloatArray:
        """Reflection (4, 4) float64 in the plane, camera frame; it is its own inverse.

        It also maps the camera to the virtual camera that takes the mirror's picture.
        """
        out = np.eye(4)
        out[:3, :3] -= 2 * np.outer(self.normal, self.normal)
        out[:3, 3] = -2 * self.distance * self.normal
        return out

    def reflect(self, points: NDArray[np.floating]) -> FloatArray:
        """Mirror images (..., 3) float64 of points (..., 3), mm, camera frame."""
        return np.asarray(points @ self.matrix[:3, :3] + self.matrix[:3, 3], np.float64)

    def reflect_directions(self, directions: NDArray[np.floating]) -> FloatArray:
        """Mirror images (..., 3) of directions: normals, or the way in which light travels."""
        return np.asarray(directions @ self.matrix[:3, :3], np.float64)

    def height(self, points: NDArray[np.floating]) -> FloatArray:
        """Distance (...) of points (..., 3) before the plane, mm; below zero behind it."""
        return np.asarray(points @ self.normal + self.distance, np.float64)

    def mask(self, camera: Camera) -> BoolArray:
        """Mask (H, W) of the pixels whose line of sight, through their centre, hits the mirror."""
        sight = lines_of_sight(camera)
        flat = self.corners[:, :2] / self.corners[:, 2:]
        turns = np.stack(
            [
                (b[0] - a[0]) * (sight[..., 1] - a[1]) - (b[1] - a[1]) * (sight[..., 0] - a[0])
                for a, b in zip(flat, np.roll(flat, -1, axis=0), strict=True)
            ]
        )
        return np.asarray((turns >= 0).all(axis=0) | (turns <= 0).all(axis=0))

    def depth(self, camera: Camera) -> NDArray[np.float32]:
        """Depth of the glass at each pixel, (H, W) float32, mm; infinite beside the mirror.

        What is drawn directly and lies deeper is hidden by the mirror.
        """
        along = -lines_of_sight(camera) @ self.normal
        glass = np.divide(self.distance, along, out=np.full(along.shape, np.inf), where=along > 0)
        return np.where(self.mask(camera), glass, np.inf).astype(np.float32)


def lines_of_sight(camera: Camera) -> FloatArray:
    """Directions (H, W, 3) float64, z = 1, camera frame, in which pixel centres look."""
    width, height = camera.size
    pixels = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=2).astype(np.float64)
    flat = cv2.undistortPoints(pixels.reshape(-1, 1, 2), camera.matrix, camera.distortion)[:, 0]
    rays = np.column_stack([flat, np.ones(len(flat))]).reshape(height, width, 3)
    focal = np.array([camera.matrix[0, 0], camera.matrix[1, 1]])
    for _ in range(_SIGHT_STEPS if camera.distorted else 0):  # OpenCV stops after five
        rays[..., :2] += (pixels - camera.project(rays)) / focal
    return np.asarray(rays)


def _check_rectangle(corners: FloatArray) -> None:
    sides = np.roll(corners, -1, axis=0) - corners
    if np.linalg.norm(sides, axis=1).min() < _SMALLEST:
        raise ParameterError("the mirror has no area", "give corners that lie apart")
    first, second = corners[2] - corners[0], corners[3] - corners[1]
    size = max(float(np.linalg.norm(first)), float(np.linalg.norm(second)))
    middles = np.linalg.norm(corners[0] + corners[2] - corners[1] - corners[3]) / 2
    lengths = abs(float(np.linalg.norm(first) - np.linalg.norm(second)))
    if max(float(middles), lengths) > _SKEW * size:
        raise ParameterError(
            "the mirror's corners make no rectangle", "give them in order around the rectangle"
        )


@dataclass(frozen=True, eq=False)
class Drawn:
    """Buffers that the worker drew of a frame.

    Parameters
    ----------
    rgba : (H, W, 4) uint8
    ids : (H, W) uint16
    cover : (H, W) uint8
    depth : (H, W) float32, mm
        Of head and props.
    glass : (H, W) bool
        Where the mirror is what is seen.
    """

    rgba: NDArray[np.uint8]
    ids: NDArray[np.uint16]
    cover: NDArray[np.uint8]
    depth: NDArray[np.float32]
    glass: BoolArray


class Glass:
    """A mirror in one camera's picture."""

    def __init__(self, mirror: Mirror, camera: Camera) -> None:
        self.mirror, self._camera = mirror, camera
        self.mask, self.depth = mirror.mask(camera), mirror.depth(camera)

    def hides(self, points: FloatArray, pixels: FloatArray) -> BoolArray:
        """Whether the mirror stands before points (N, 3), camera frame, at pixels (N, 2)."""
        row, column = self._nearest(pixels)
        return np.asarray(self.depth[row, column] < points[:, 2])

    def shows(self, pixels: FloatArray, seen: BoolArray) -> BoolArray:
        """Whether the mirror is what is seen, (H, W), at pixels (N, 2)."""
        row, column = self._nearest(pixels)
        return np.asarray(seen[row, column])

    def _nearest(self, pixels: FloatArray) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        width, height = self._camera.size
        column = np.clip(np.rint(pixels[:, 0]), 0, width - 1).astype(np.intp)
        return np.clip(np.rint(pixels[:, 1]), 0, height - 1).astype(np.intp), column


def joined(direct: Drawn, mirrored: Drawn, glass: Glass) -> Drawn:
    """The direct view, with the mirror's picture where the mirror is what is seen.

    What stands between camera and mirror stays; what stands behind the mirror is hidden by it.
    """
    before = (direct.depth > 0) & (direct.depth < glass.depth)
    seen = glass.mask & ~before
    # Edges of what stands before the mirror are blended with what is in the mirror.
    edge = seen & (cv2.dilate(before.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0)
    alpha = np.where(edge, direct.rgba[..., 3], 0).astype(np.float32)[..., None] / 255
    inside = _SHINE * mirrored.rgba.astype(np.float32)
    inside[..., 3] += 255 * (1 - _SHINE)  # the background is seen in the mirror, too
    over = np.where(edge[..., None], direct.rgba.astype(np.float32), 0) + inside * (1 - alpha)
    rgba = np.where(seen[..., None], np.rint(over), direct.rgba).astype(np.uint8)
    return Drawn(
        rgba,
        np.where(seen, mirrored.ids, direct.ids).astype(np.uint16),
        np.where(seen, mirrored.cover, direct.cover).astype(np.uint8),
        np.where(seen, mirrored.depth, direct.depth).astype(np.float32),
        seen,
    )
