"""Frames in which a tracker failed, and how often a result's intervals hold the truth."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.errors import ParameterError

LIMIT_MM = 5.0
"""RMS error of the lips, mm, above which a frame counts as failed."""

LIMIT_NORMALISED = 0.08
"""Mean point error over the distance of the eyes above which a frame counts as failed."""


def failed(error: ArrayLike, limit: float) -> BoolArray:
    """Frames (T,) that were lost (error not finite) or whose error is above the limit.

    The failure rate of 300-VW (Shen et al., The first facial landmark tracking in-the-wild
    challenge, ICCV workshops (2015)), whose limit is `LIMIT_NORMALISED`; `LIMIT_MM` is ours.
    """
    given = np.asarray(error, np.float64)
    return np.asarray(~np.isfinite(given) | (given > limit))


def covered(lower: ArrayLike, upper: ArrayLike, truth: ArrayLike) -> FloatArray:
    """Share of the numbers of each frame that lie in their interval, (T,); NaN without interval.

    The mean over frames is the empirical coverage, to be compared with the nominal one (Gneiting
    & Raftery, Strictly proper scoring rules, prediction, and estimation, J. Am. Stat. Assoc. 102
    (2007), section 6). A number on the border is inside.

    Parameters
    ----------
    lower, upper, truth : (T, ...) float
        Of one shape.

    Raises
    ------
    ParameterError
        If the shapes differ, or an upper end lies below its lower end.
    """
    low, high, true = (np.asarray(a, np.float64) for a in (lower, upper, truth))
    if not low.shape == high.shape == true.shape:
        raise ParameterError(
            f"intervals of shapes {low.shape} and {high.shape} do not fit truth {true.shape}",
            "give an interval for every number",
        )
    if (high < low).any():
        raise ParameterError("an interval ends below its beginning", "swap lower and upper")
    low, high, true = (a.reshape(len(a), -1) for a in (low, high, true))
    known = (np.isfinite(low) & np.isfinite(high)).all(axis=1)
    return np.where(known, ((low <= true) & (true <= high)).mean(axis=1), np.nan)
