"""Coverage of a result's intervals: how often they hold the truth."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError


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
