"""Squared errors of a batch, row by row, as Gauss-Newton steps need them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class Rows:
    """A sum of squares, taken apart.

    Parameters
    ----------
    rows : (B, K) float32 or float64
        Differences, 0 where there is none.
    there : (B, K) bool
        Where there is one.
    value : (B,) float64
        The sum, with what is charged where nothing could be compared.
    mixer : (K, K) float64 or None
        What the rows are multiplied by before they are squared.
    """

    rows: NDArray[np.floating]
    there: BoolArray
    value: FloatArray
    mixer: FloatArray | None = None

    def mixed(self, rows: NDArray[np.floating]) -> FloatArray:
        """Rows, or differences of rows, as they are squared."""
        return np.asarray(rows if self.mixer is None else rows @ self.mixer.T)
