"""The places on facets that are nearest to points.

trimesh is imported where it is needed: it takes as long as all the rest of a small program.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray

_ROUNDING = 1e-9  # of the points' distances, mm


def nearest_on_facets(
    triangles: FloatArray, points: FloatArray
) -> tuple[NDArray[np.int64], FloatArray]:
    """The facet (N,) of (F, 3, 3) nearest to each point (N, 3), and the place (N, 3) on it.

    Of several facets that are as near, it is the first.
    """
    centre = triangles.mean(axis=1)
    reach = np.linalg.norm(triangles - centre[:, None], axis=2).max(axis=1)
    away = np.linalg.norm(points[:, None] - centre, axis=2)
    # A facet lies within its reach of its centre, so only these can hold the nearest place
    which, facet = np.nonzero(away - reach <= away.min(axis=1, keepdims=True) + _ROUNDING)
    found = nearest_in(triangles[facet], points[which])
    distance = np.linalg.norm(found - points[which], axis=1)
    best = np.lexsort((facet, distance, which))[np.searchsorted(which, np.arange(len(points)))]
    return facet[best], np.asarray(found[best], np.float64)


def nearest_in(triangles: FloatArray, points: FloatArray) -> FloatArray:
    """Place (N, 3) on each facet (N, 3, 3) that is nearest to its own point (N, 3)."""
    from trimesh.triangles import closest_point

    return np.asarray(closest_point(triangles, points), np.float64)


def barycentric(triangles: FloatArray, points: FloatArray) -> FloatArray:
    """Weights (N, 3) of the corners of facets (N, 3, 3) whose sums are points (N, 3) on them."""
    from trimesh.triangles import points_to_barycentric

    return np.asarray(points_to_barycentric(triangles, points), np.float64)
