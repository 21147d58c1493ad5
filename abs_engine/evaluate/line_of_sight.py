"""The error of the head's position along and across the line of sight."""

from __future__ import annotations

import numpy as np

from abs_engine.core.arrays import FloatArray


def position_errors(found: FloatArray, true: FloatArray) -> tuple[float, float]:
    """Root mean square error of positions along and across the line of sight.

    One camera sees the first, the distance, only by the size of what it sees; the second by its
    place in the picture.

    Parameters
    ----------
    found, true : (T, 3) float64, mm, camera frame
        Rows of `found` with NaN are left out.

    Returns
    -------
    along, across : float, mm
        NaN where no row is left.
    """
    kept = np.isfinite(found).all(axis=1)
    if not kept.any():
        return float("nan"), float("nan")
    away, sight = (found - true)[kept], true[kept]
    along = (away * sight).sum(axis=1) / np.linalg.norm(sight, axis=1)
    across = (away**2).sum(axis=1) - along**2
    return float(np.sqrt(np.mean(along**2))), float(np.sqrt(np.mean(np.maximum(across, 0))))
