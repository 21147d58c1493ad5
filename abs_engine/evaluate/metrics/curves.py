"""Curves over time: how they differ from the truth, and what of them is a slip."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import nearest_rotation
from abs_engine.evaluate.metrics.bootstrap import compared

STABLE = [27, 28, 29, 30, 36, 39, 42, 45]
"""Landmarks that move least with expression: bridge of the nose and corners of the eyes."""


def correlation(estimated: ArrayLike, truth: ArrayLike) -> float:
    """Pearson's correlation of two curves (T,), such as lip aperture; NaN where one is constant.

    Raises
    ------
    ParameterError
        If the lengths differ, or no frame was tracked.
    """
    remedy = "compare the same frames of one clip"
    found, true = compared(estimated, truth, "curves", (None,), remedy)
    chosen = np.isfinite(found)
    if not chosen.any():
        raise ParameterError("no frame was tracked", "look at the overlay of the run")
    found, true = found[chosen], true[chosen]
    constant = np.ptp(found) == 0 or np.ptp(true) == 0
    return np.nan if constant else float(np.corrcoef(found, true)[0, 1])


def lip_curves(outer_12: ArrayLike, inner_8: ArrayLike) -> dict[str, FloatArray]:
    """The three curves by which lips are described, from their points in the head frame.

    Parameters
    ----------
    outer_12 : (T, 12, 3) float, mm, head frame
        Points 48 to 59 of the 68.
    inner_8 : (T, 8, 3) float, mm, head frame
        Points 60 to 67.

    Returns
    -------
    dict of str to (T,) float64, mm
        `aperture`: y of point 62 less y of point 66, 0 where the lips overlap; `width`: distance
        between points 48 and 54; `protrusion`: mean z of points 51 and 57, how far the middle of
        the lips lies in front of the ear canals.

    Notes
    -----
    These are the internal height, the external width and the forward position of the two lips
    by which Abry & Boe, "Laws" for lips, Speech Communication 5 (1986), describe lip shapes;
    which points stand for them is our choice.
    """
    outer, inner = np.asarray(outer_12, np.float64), np.asarray(inner_8, np.float64)
    return {
        "aperture": np.maximum(inner[:, 2, 1] - inner[:, 6, 1], 0.0),
        "width": np.linalg.norm(outer[:, 0] - outer[:, 6], axis=1),
        "protrusion": (outer[:, 3, 2] + outer[:, 9, 2]) / 2,
    }


def landmark_curves(points: FloatArray, rest: FloatArray | None = None) -> dict[str, FloatArray]:
    """Lip curves of the 68 landmarks, see `lip_curves`.

    Parameters
    ----------
    points : (T, 68, 3) float64, mm
    rest : (68, 3) float64, mm, head frame, optional
        The person's landmarks at rest: the stable ones of each frame are laid on them first. None
        for points in head coordinates, which are taken as they are.
    """
    placed = points if rest is None else lay_on_rest(points, rest)
    return lip_curves(placed[:, 48:60], placed[:, 60:68])


def lay_on_rest(points: FloatArray, rest: FloatArray) -> FloatArray:
    """Landmarks (T, 68, 3) after the rigid motion of each frame that fits `STABLE` to rest best.

    NaN where one of `STABLE` is missing. By least squares, never a mirror image.
    """
    out = np.full(points.shape, np.nan)
    known = np.isfinite(points[:, STABLE]).all(axis=(1, 2))
    if not known.any():
        return out
    here, there = points[known], rest[STABLE]
    centre, middle = here[:, STABLE].mean(axis=1, keepdims=True), there.mean(axis=0)
    turn = nearest_rotation(np.swapaxes(here[:, STABLE] - centre, 1, 2) @ (there - middle))
    out[known] = (here - centre) @ turn + middle
    return out


def spikes(curve: ArrayLike, threshold: float) -> int:
    """Number of frames that stand out from both neighbours, to one side, by more than `threshold`.

    No lip moves there and back within two frames; such a frame is a tracker's slip. The first and
    the last frame, and neighbours of frames that were not tracked, never count.
    """
    values = np.asarray(curve, np.float64)
    before, here, after = values[:-2], values[1:-1], values[2:]
    above = here - np.maximum(before, after) > threshold
    below = np.minimum(before, after) - here > threshold
    return int((above | below).sum())
