"""The frame of the head: what removes its rigid motion, so that only the lips' own is left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from abs_engine.capture.settings import CAPTURE
from abs_engine.core.arrays import BoolArray, FloatArray, IntArray
from abs_engine.core.errors import (
    DegenerateViewsError,
    ModelFormatError,
    ParameterError,
    TooFewPointsError,
)
from abs_engine.core.geometry import Pose
from abs_engine.core.words import listed

_ROUNDS = 10
_SETTLED = 1e-6  # mm
AXES = ("corner_right", "corner_left", "upper_outer_2", "lower_outer_2")
"""Dots that `mouth_axes` needs."""


@dataclass(frozen=True, eq=False)
class HeadMotion:
    """Pose of the head in each frame.

    Parameters
    ----------
    rotations : (T, 3) float64
        Rotation vectors, head frame to world, radians; NaN where the head was not found.
    translations : (T, 3) float64, mm, world frame
    error : (T,) float64, mm
        Root mean square distance of the rigid points from where a rigid head has them; 0 where
        the motion was given.
    """

    rotations: FloatArray
    translations: FloatArray
    error: FloatArray

    @property
    def found(self) -> BoolArray:
        """In which frames (T,) the head was found."""
        return np.asarray(np.isfinite(self.rotations).all(axis=1))

    def to_head(self, points: FloatArray) -> FloatArray:
        """World points (T, N, 3), mm, in the head frame; NaN where the head was not found."""
        out = np.full(points.shape, np.nan)
        for t in np.flatnonzero(self.found):
            pose = Pose.from_vectors(self.rotations[t], self.translations[t])
            out[t] = (points[t] - pose.translation) @ pose.rotation
        return out


def rigid_motion(points: FloatArray, reference: FloatArray | None = None) -> HeadMotion:
    """The head's motion from points that are fixed to the skull.

    The points' mean shape over all frames is found first (generalised Procrustes analysis), and
    turned into the reference; each frame is then laid on it (Kabsch 1976, weights all equal). So
    errors of the reference do not change from frame to frame.

    Parameters
    ----------
    points : (T, K, 3) float64, mm, world frame
        NaN where a point is not known. A frame with fewer than three, or three in a line, has no
        motion.
    reference : (K, 3) float64, mm, head frame, optional
        Where the points are in the head frame. By default the head frame is the world frame as
        the head stands in the first frame with all points.

    Raises
    ------
    TooFewPointsError
        If there are fewer than three points, or no frame has them all.
    DegenerateViewsError
        If the points lie along one line, which leaves a rotation open.
    """
    points = np.asarray(points, np.float64)
    if points.shape[1] < 3:
        raise TooFewPointsError(
            f"{points.shape[1]} rigid points do not fix the head's rotation",
            "name three or more that do not move with the face, or give the head's pose",
        )
    whole = np.flatnonzero(np.isfinite(points).all(axis=(1, 2)))
    if not len(whole):
        raise TooFewPointsError(
            "there is no frame in which all rigid points were found", "correct them in one frame"
        )
    start = points[whole[0]]
    if _spread(start) < CAPTURE.flat:
        raise DegenerateViewsError(
            "the rigid points lie in one line, which leaves a rotation of the head open",
            "name one that lies beside it",
        )
    mean = _mean_shape(points, start)
    turned, placed = _lay(mean, start if reference is None else np.asarray(reference, np.float64))
    mean = mean @ turned.as_matrix().T + placed
    rotations, translations = np.full((2, len(points), 3), np.nan)
    error = np.full(len(points), np.nan)
    for t, frame in enumerate(points):
        known = np.asarray(np.isfinite(frame).all(axis=1))
        if known.sum() < 3 or _spread(mean[known]) < CAPTURE.flat:
            continue
        rotation, translations[t] = _lay(mean[known], frame[known])
        rotations[t] = rotation.as_rotvec()
        off = rotation.apply(mean[known]) + translations[t] - frame[known]
        error[t] = np.sqrt((off**2).sum(axis=1).mean())
    return HeadMotion(rotations, translations, error)


def follow_point(points: FloatArray, axes: FloatArray) -> HeadMotion:
    """The motion of a head that is only shifted, never turned.

    Parameters
    ----------
    points : (T, 3) float64, mm, world frame
        One point of the skull, the origin of the head frame.
    axes : (3, 3) float64
        Rows are the head frame's axes in the world frame.
    """
    turn = Rotation.from_matrix(axes.T).as_rotvec()
    known = np.asarray(np.isfinite(points).all(axis=1))
    rotations = np.where(known[:, None], turn, np.nan)
    return HeadMotion(rotations, np.array(points, np.float64), np.where(known, 0.0, np.nan))


def mouth_axes(points: FloatArray, names: Sequence[str]) -> FloatArray:
    """Axes of a head from the dots of its resting mouth: where no reference is given.

    x runs along the lips to the subject's left, y from the lower to the upper lip's middle, as far
    as it is perpendicular to x; z is perpendicular to both. The axes of a head given by its skull
    may be turned some degrees against these.

    Parameters
    ----------
    points : (N, 3) float64, mm, any frame
    names : sequence of str
        Among them those of `AXES`: the corners and the middles of the outer rows.

    Returns
    -------
    (3, 3) float64
        Rows are the axes.

    Raises
    ------
    TooFewPointsError
        If one of these points is missing.
    DegenerateViewsError
        If they lie in one line.
    """
    at = {}
    for name in AXES:
        if name not in names:
            raise TooFewPointsError(
                f"the axes of the head need the point '{name}'",
                "give it, or a reference of the rigid points",
            )
        at[name] = points[list(names).index(name)]
        if not np.isfinite(at[name]).all():
            raise TooFewPointsError(
                f"the axes of the head need '{name}', which is in no frame with the others",
                "mark it in one such frame, or give a reference of the rigid points",
            )
    x = at["corner_left"] - at["corner_right"]
    y = at["upper_outer_2"] - at["lower_outer_2"]
    z = np.cross(x, y)
    if np.linalg.norm(z) < 1.0:
        raise DegenerateViewsError("the dots of the mouth lie in one line", "check their places")
    axes = np.stack([x, np.cross(z, x), z])
    return np.asarray(axes / np.linalg.norm(axes, axis=1, keepdims=True))


def reference_of(given: Mapping[str, FloatArray], names: Sequence[str]) -> FloatArray:
    """Places (K, 3) of the named points.

    Raises
    ------
    ModelFormatError
        If one is missing.
    """
    lacking = [name for name in names if name not in given]
    if lacking:
        raise ModelFormatError(
            f"the reference has no point '{lacking[0]}'", "give every rigid point in it"
        )
    return np.stack([given[name] for name in names])


def _mean_shape(points: FloatArray, start: FloatArray) -> FloatArray:
    mean = start
    for _ in range(_ROUNDS):
        laid = np.full(points.shape, np.nan)
        for t, frame in enumerate(points):
            known = np.asarray(np.isfinite(frame).all(axis=1))
            if known.sum() >= 3 and _spread(mean[known]) >= CAPTURE.flat:
                rotation, shift = _lay(frame[known], mean[known])
                laid[t, known] = rotation.apply(frame[known]) + shift
        before, mean = mean, np.nanmean(laid, axis=0)
        if np.abs(mean - before).max() < _SETTLED:
            break
    return mean


def _lay(source: FloatArray, target: FloatArray) -> tuple[Rotation, FloatArray]:
    """Rotation and shift that lay source points (K, 3) on target points (K, 3)."""
    a, b = source.mean(axis=0), target.mean(axis=0)
    u, _, vt = np.linalg.svd((target - b).T @ (source - a))
    turn = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    rotation = Rotation.from_matrix(turn)
    return rotation, b - rotation.apply(a)


def _spread(points: FloatArray) -> float:
    """Root mean square distance from the straight line that fits best, mm."""
    values = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return float(np.sqrt((values[1:] ** 2).sum() / len(points)))


def check_names(names: Sequence[str], wanted: Sequence[str]) -> IntArray:
    """Numbers of the wanted points.

    Raises
    ------
    ParameterError
        If one is not among the names.
    """
    lacking = [name for name in wanted if name not in names]
    if lacking:
        raise ParameterError(f"there is no point '{lacking[0]}'", f"the points are {listed(names)}")
    return np.array([list(names).index(name) for name in wanted], np.int64)
