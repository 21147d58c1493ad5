"""Luminance of RGB pixels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray

_LUMA = np.array([0.299, 0.587, 0.114])


def luminance(pixels: NDArray[np.generic]) -> FloatArray:
    """Luminance (...,), 0 to 255, of RGB pixels (..., 3)."""
    return np.asarray(np.asarray(pixels, np.float64) @ _LUMA)
