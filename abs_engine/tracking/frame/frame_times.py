"""Spacing of frames in time."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from abs_engine.core.arrays import FloatArray

_EVEN, _MOST_UNEVEN = 0.01, 0.25  # of a frame's duration
_ROUNDED = 1.1e-3  # seconds: files with whole milliseconds round the times of two frames


def usual_duration(times: FloatArray, rate: float) -> float:
    """Duration of most frames that are shown at times (T,), s; at a rate if there is but one."""
    return float(np.median(np.diff(times))) if len(times) > 1 else 1 / rate


def evenly_spaced(times: ArrayLike, rate: float) -> bool:
    """Whether frames are shown at a rate, but for the rounding of their times (T,), s."""
    times = np.asarray(times, np.float64)
    if len(times) < 2:
        return True
    slack = max(_EVEN / rate, min(_ROUNDED, _MOST_UNEVEN / rate))
    apart = np.abs(np.diff(times) - 1 / rate).max()
    whole = abs(times[-1] - times[0] - (len(times) - 1) / rate)
    return bool(apart <= slack and whole <= slack + _EVEN * (len(times) - 1) / rate)
