"""When lips touch: measured on the mesh, not read from the script."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from abs_engine.assets import Speaker

CLOSED_BELOW = 0.25
"""Lips whose widest gap is smaller than this (mm) count as closed."""


def widest_gap(speaker: Speaker, vertices: NDArray[np.float32]) -> float:
    """Widest gap between the lips, as seen from the front.

    Columns 1 mm apart cross the mouth from corner to corner. In each, the gap is the height
    of the lowest point of the upper lip above the highest point of the lower lip.

    Parameters
    ----------
    speaker : Speaker
    vertices : (V, 3) float32, mm, head frame

    Returns
    -------
    float
        mm; negative where the lips overlap in every column.
    """
    upper, lower = _lip_edges(speaker)
    right, left = np.sort(vertices[speaker.landmarks["mouth_corners"], 0])
    reach = 0.4 * (left - right)
    columns = (right + left) / 2 + np.arange(-reach, reach, 1.0)
    bottom = -_highest(columns, vertices[upper] * [1, -1, 1])
    top = _highest(columns, vertices[lower])
    return float((bottom - top).max())


def _highest(columns: NDArray[np.float64], edges: NDArray[np.floating]) -> NDArray[np.float64]:
    """Largest y at which edges (E, 2, 3) cross the planes x = columns (C,); -inf without any."""
    start, end = edges[:, 0], edges[:, 1]
    run = end[:, 0] - start[:, 0]
    share = (columns[:, None] - start[:, 0]) / np.where(np.abs(run) < 1e-6, 1e-6, run)
    y = start[:, 1] + share * (end[:, 1] - start[:, 1])
    return np.asarray(np.where((share >= 0) & (share <= 1), y, -np.inf).max(axis=1), np.float64)


@lru_cache(maxsize=4)
def _lip_edges(speaker: Speaker) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Edges (E, 2) of the facets of the upper and of the lower lip."""
    edges = []
    for name in ("upper_lip", "lower_lip"):
        faces = speaker.faces[speaker.facet_class == speaker.class_id(name)]
        both = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), 1)
        edges.append(np.unique(both, axis=0))
    return edges[0], edges[1]
