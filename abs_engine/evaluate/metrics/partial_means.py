"""Means over what a system gives."""

from __future__ import annotations

import numpy as np

from abs_engine.core.arrays import FloatArray


def mean_of_given(values: FloatArray) -> FloatArray:
    """Mean (T,) over what is finite in (T, N); NaN where nothing is."""
    given = np.isfinite(values)
    count = given.sum(axis=1)
    total = np.where(given, values, 0.0).sum(axis=1)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)
