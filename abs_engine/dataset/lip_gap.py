"""The gap between the lips of any mesh."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray


def widest_gap(
    vertices: NDArray[np.float32],
    corners: NDArray[np.integer],
    upper: NDArray[np.integer],
    lower: NDArray[np.integer],
) -> float:
    """Widest gap between the lips seen from the front, mm; negative where they overlap.

    Minus infinity where the mouth has no width.
    In columns 1 mm apart over the middle four fifths of the mouth: the lowest point of the edges
    of the upper lip less the highest point of those of the lower lip.

    Parameters
    ----------
    vertices : (V, 3)
    corners : (2,) int
        Corners of the mouth.
    upper, lower : (E, 2) int
        Edges of the lips' facets, each once.
    """
    right, left = np.sort(vertices[corners, 0].astype(np.float64))
    reach = 0.4 * (left - right)
    columns = (right + left) / 2 + np.arange(-reach, reach, 1.0)
    bottom = -_highest(columns, vertices[upper] * [1, -1, 1])
    top = _highest(columns, vertices[lower])
    return float((bottom - top).max(initial=-np.inf))


def _highest(columns: FloatArray, edges: NDArray[np.floating]) -> FloatArray:
    """Largest y at which edges (E, 2, 3) cross planes of constant x (C,); -inf without any.

    Edges that lie in such a plane have neighbours that cross it at their ends.
    """
    start, end = edges[:, 0].astype(np.float64), edges[:, 1].astype(np.float64)
    run = end[:, 0] - start[:, 0]
    steep = np.abs(run) > 1e-9
    start, end, run = start[steep], end[steep], run[steep]
    share = (columns[:, None] - start[:, 0]) / run
    y = start[:, 1] + share * (end[:, 1] - start[:, 1])
    return np.asarray(np.where((share >= 0) & (share <= 1), y, -np.inf).max(axis=1), np.float64)
