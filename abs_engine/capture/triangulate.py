"""Points in space from where two or more views see them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from abs_engine.capture.settings import CAPTURE
from abs_engine.capture.view import View
from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.errors import DegenerateViewsError, ParameterError

_NARROWEST = np.radians(CAPTURE.narrowest)

_STEPS = 10
_SETTLED = 1e-7  # mm


@dataclass(frozen=True, eq=False)
class Triangulated:
    """Points in space.

    Parameters
    ----------
    points : (..., 3) float64, mm, world frame
        NaN where fewer than two views saw the point, the lines of sight cross under less than
        `CAPTURE.narrowest`, or it came out behind a camera.
    error : (...) float64, px
        Root mean square distance, over the views, of the seen from the reprojected point.
    """

    points: FloatArray
    error: FloatArray

    @property
    def known(self) -> BoolArray:
        """Mask (...) of the points that have a place."""
        return np.asarray(np.isfinite(self.error))


def triangulate(views: Sequence[View], pixels: FloatArray) -> Triangulated:
    """The points whose reprojection comes nearest to what the views saw.

    Linear equations give the start (Hartley and Zisserman, Multiple View Geometry, 2003, section
    12.2), Gauss-Newton steps the least squares of the distances in pixels.

    Parameters
    ----------
    views : sequence of View, V of them, two or more
    pixels : (V, ..., 2) float64
        As seen, with lens distortion; NaN where a view does not see a point.

    Raises
    ------
    ParameterError
        If there are fewer than two views, or pixels for another number.
    DegenerateViewsError
        If the lines of sight of half of the points or more are so nearly parallel that depth is
        left open.
    """
    pixels = np.asarray(pixels, np.float64)
    if len(views) < 2 or pixels.shape[0] != len(views) or pixels.shape[-1] != 2:
        raise ParameterError(
            f"{len(views)} views and pixels of shape {pixels.shape} do not make points",
            "give two views or more, and (views, ..., 2) pixels",
        )
    shape, flat = pixels.shape[1:-1], pixels.reshape(len(views), -1, 2)
    seen = np.asarray(np.isfinite(flat).all(axis=2))
    points = np.full((flat.shape[1], 3), np.nan)
    error = np.full(flat.shape[1], np.nan)
    use = np.flatnonzero(seen.sum(axis=0) >= 2)
    if len(use):
        use = use[_crossing(views, flat[:, use])]
        start = _linear(views, flat[:, use], seen[:, use])
        place, error[use] = _refine(views, flat[:, use], seen[:, use], start)
        points[use] = place
        lost = use[~np.isfinite(error[use]) | _behind(views, place, seen[:, use])]
        points[lost], error[lost] = np.nan, np.nan
    return Triangulated(points.reshape(*shape, 3), error.reshape(shape))


def crossing_angles(views: Sequence[View], pixels: FloatArray) -> FloatArray:
    """Largest angle (N,), radians, between the lines of sight of points seen at (V, N, 2)."""
    sight = np.stack([v.directions(p) for v, p in zip(views, pixels, strict=True)])
    widest = np.zeros(pixels.shape[1])
    for i in range(len(views)):
        for j in range(i):
            sine = np.linalg.norm(np.cross(sight[i], sight[j]), axis=1)
            angle = np.arctan2(sine, (sight[i] * sight[j]).sum(axis=1))
            widest = np.fmax(widest, angle)
    return widest


def check_sides(views: Sequence[View], points: FloatArray) -> None:
    """Refuse points (N, 3), mm, world frame, most of which lie behind a mirror that shows them.

    There they come to lie, as the mirror image of what they are, if the direct view and the
    mirror's are exchanged; both explain the pixels equally well.

    Raises
    ------
    ParameterError
        If more than half of the points that are known lie there.
    """
    known = points[np.isfinite(points).all(axis=-1)]
    for view in views:
        if view.mirror is None or not len(known):
            continue
        if np.median(view.mirror.height(view.pose.apply(known))) < 0:
            raise ParameterError(
                "the points lie behind the mirror",
                "exchange the views: view 1 is the direct one, view 2 the mirror image",
            )


def _crossing(views: Sequence[View], pixels: FloatArray) -> BoolArray:
    """Mask (N,) of the points that have lines of sight that cross widely enough."""
    angles = crossing_angles(views, pixels)
    middle = float(np.median(angles))  # a point that was mistaken may be seen under any angle
    if middle < _NARROWEST:
        raise DegenerateViewsError(
            f"the views look along nearly the same lines (half of the points within "
            f"{np.degrees(middle):.1f} degrees), which leaves depth open",
            "place the cameras or the mirror farther apart",
        )
    return np.asarray(angles >= _NARROWEST)


def _linear(views: Sequence[View], pixels: FloatArray, seen: BoolArray) -> FloatArray:
    """Least squares in pinhole coordinates, scaled so that a row is about a pixel at unit depth."""
    rows, right = [], []
    for view, at, mask in zip(views, pixels, seen, strict=True):
        ideal = np.where(mask[:, None], view.camera.undistort(at), 0.0)
        linear, offset = view.motion
        for k in range(2):
            row = ideal[:, k, None] * linear[2] - linear[k]
            rows.append(np.where(mask[:, None], row, 0.0))
            right.append(np.where(mask, offset[k] - ideal[:, k] * offset[2], 0.0))
    matrix, vector = np.stack(rows, axis=1), np.stack(right, axis=1)
    return np.asarray((np.linalg.pinv(matrix) @ vector[..., None])[..., 0])


def _refine(
    views: Sequence[View], pixels: FloatArray, seen: BoolArray, start: FloatArray
) -> tuple[FloatArray, FloatArray]:
    points = start
    for _ in range(_STEPS):
        residual = _residual(views, pixels, seen, points)
        beside = [_residual(views, pixels, seen, points + 1e-3 * axis) for axis in np.eye(3)]
        step = np.stack([(other - residual) / 1e-3 for other in beside], axis=-1)
        move = (np.linalg.pinv(step) @ residual[..., None])[..., 0]
        points = points - move
        if np.abs(move).max() < _SETTLED:
            break
    residual = _residual(views, pixels, seen, points)
    return points, np.sqrt((residual**2).sum(axis=1) / seen.sum(axis=0))


def _residual(
    views: Sequence[View], pixels: FloatArray, seen: BoolArray, points: FloatArray
) -> FloatArray:
    """Reprojected minus seen, (N, 2 V) px; 0 where a view does not see the point."""
    parts = [
        np.where(mask[:, None], view.project(points) - at, 0.0)
        for view, at, mask in zip(views, pixels, seen, strict=True)
    ]
    return np.concatenate(parts, axis=1)


def _behind(views: Sequence[View], points: FloatArray, seen: BoolArray) -> BoolArray:
    depth = np.stack([view.seen(points)[:, 2] for view in views])
    return np.asarray(((depth <= 0) & seen).any(axis=0))
