"""Arrays by what they hold, for annotations; stretches of a mask, and a few of many things."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Float32Array = NDArray[np.float32]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
Image = NDArray[np.uint8]
"""(H, W, 3) RGB or (H, W) grey, row 0 at the top."""


def stretches(mask: BoolArray) -> list[list[int]]:
    """First of each run of true values in a mask (T,), and the one after its last."""
    edges = np.flatnonzero(np.diff(np.r_[False, mask, False].astype(np.int8)))
    found: list[list[int]] = edges.reshape(-1, 2).tolist()
    return found


def evenly(count: int, most: int) -> list[int]:
    """Indices of at most so many things of a count, evenly spread, the first and last included.

    Of one, it is the first.
    """
    spread: list[int] = np.linspace(0, count - 1, min(most, count)).round().astype(int).tolist()
    return spread
