"""Lip curves of systems whose own head axes differ from ours."""

from __future__ import annotations

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.evaluate import metrics

STABLE = [27, 28, 29, 30, 36, 39, 42, 45]
"""Landmarks that move least with expression: bridge of the nose and corners of the eyes."""


def landmark_curves(points: FloatArray, rest: FloatArray | None) -> dict[str, FloatArray]:
    """Lip curves of the 68 landmarks, see `metrics.lip_curves`.

    Parameters
    ----------
    points : (T, 68, 3) float64, mm
    rest : (68, 3) float64, mm, head frame, optional
        The person's landmarks at rest: the stable ones of each frame are laid on them first. None
        for points in head coordinates, which are taken as they are.
    """
    placed = points if rest is None else lay_on_rest(points, rest)
    return metrics.lip_curves(placed[:, 48:60], placed[:, 60:68])


def lay_on_rest(points: FloatArray, rest: FloatArray) -> FloatArray:
    """Landmarks (T, 68, 3) after the rigid motion of each frame that fits `STABLE` to rest best.

    NaN where one of `STABLE` is missing. Least squares (Kabsch 1976), never a mirror image.
    """
    out = np.full(points.shape, np.nan)
    known = np.isfinite(points[:, STABLE]).all(axis=(1, 2))
    if not known.any():
        return out
    here, there = points[known], rest[STABLE]
    centre, middle = here[:, STABLE].mean(axis=1, keepdims=True), there.mean(axis=0)
    u, _, vt = np.linalg.svd(np.swapaxes(here[:, STABLE] - centre, 1, 2) @ (there - middle))
    u[..., 2] *= np.sign(np.linalg.det(u @ vt))[:, None]
    out[known] = (here - centre) @ (u @ vt) + middle
    return out
