"""Errors of the head's pose. Rotations are rotation vectors (T, 3), radians."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from abs_engine.core.arrays import FloatArray
from abs_engine.core.geometry import nearest_rotation, rotations


def head_angle(estimated: ArrayLike, truth: ArrayLike) -> FloatArray:
    """Geodesic distance (T,) of rotations, degrees: the angle of the turn between them.

    Metric 6 of Huynh, Metrics for 3D rotations, J. Math. Imaging and Vision 35 (2009).
    """
    return _angle(_matrices(estimated), _matrices(truth))


def head_angle_without_offset(
    estimated: ArrayLike, truth: ArrayLike, side: str = "head"
) -> FloatArray:
    """`head_angle` after the one constant turn that a system's own axes may differ by.

    Parameters
    ----------
    estimated, truth : (T, 3) float
    side : {"head", "camera"}
        Whose axes are the system's own: those it gives the head (R_true = R_estimated C), or those
        it measures in (R_true = C R_estimated).

    Notes
    -----
    C is the rotation nearest, in the sum of squared matrix elements, to all differences: the
    chordal mean (Hartley et al., Rotation averaging, Int. J. Computer Vision 103 (2013)).
    """
    found, true = _matrices(estimated), _matrices(truth)
    back = np.swapaxes(found, 1, 2)
    between = back @ true if side == "head" else true @ back
    known = np.isfinite(between).all(axis=(1, 2))
    if not known.any():
        return np.full(len(found), np.nan)
    constant = nearest_rotation(between[known].sum(axis=0))
    return _angle(found @ constant if side == "head" else constant @ found, true)


def head_distance(estimated: ArrayLike, truth: ArrayLike) -> FloatArray:
    """Distance (T,), mm, of the head's origins (T, 3) in the camera frame."""
    away = np.asarray(estimated, np.float64) - np.asarray(truth, np.float64)
    return np.asarray(np.linalg.norm(away, axis=1))


def position_errors(found: FloatArray, true: FloatArray) -> tuple[float, float]:
    """Root mean square errors (mm) of positions along and across the line of sight; or NaN.

    One camera sees the first, the distance, only by the size of what it sees; the second by its
    place in the picture.

    Parameters
    ----------
    found, true : (T, 3) float64, mm, camera frame
        Rows of `found` with NaN are left out.
    """
    kept = np.isfinite(found).all(axis=1)
    if not kept.any():
        return float("nan"), float("nan")
    away, sight = (found - true)[kept], true[kept]
    along = (away * sight).sum(axis=1) / np.linalg.norm(sight, axis=1)
    across = (away**2).sum(axis=1) - along**2
    return float(np.sqrt(np.mean(along**2))), float(np.sqrt(np.mean(np.maximum(across, 0))))


def _matrices(vectors: ArrayLike) -> FloatArray:
    return rotations(np.asarray(vectors, np.float64))


def _angle(found: FloatArray, true: FloatArray) -> FloatArray:
    """Angle (T,), degrees, between rotation matrices (T, 3, 3).

    From the distance of the matrices, |A - B| = 2 sqrt(2) sin(angle / 2), which is exact near 0,
    where the arc cosine of the trace is not.
    """
    chord = np.linalg.norm(found - true, axis=(1, 2)) / np.sqrt(8.0)
    return np.asarray(np.degrees(2 * np.arcsin(np.minimum(chord, 1.0))))
