"""Interpolation of vertex values at every pixel of a drawing, compiled."""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

import numba
import numpy as np

from abs_engine.core.compiled import LOOP


@numba.njit(**LOOP, error_model="numpy")
def at_pixels(facet, weights, faces, values):
    """Values (V, D) of vertices between them, (H, W, D); 0 where no facet is drawn.

    `facet` (H, W) is 1 + the number of a facet, 0 of none; `weights` (H, W, 3) barycentric.
    """
    height, width = facet.shape
    out = np.zeros((height, width, values.shape[1]))
    for y in range(height):
        for x in range(width):
            if facet[y, x] == 0:
                continue
            for k in range(3):
                vertex, share = faces[facet[y, x] - 1, k], weights[y, x, k]
                for d in range(values.shape[1]):
                    out[y, x, d] += share * values[vertex, d]
    return out
