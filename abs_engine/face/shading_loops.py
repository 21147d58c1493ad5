"""Loops over the points of shaded skin, compiled: see `shading`."""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

import numba
import numpy as np

from abs_engine.core.compiled import LOOP
from abs_engine.core.facet_loops import unit_normals


@numba.njit(**LOOP, error_model="numpy")
def places_and_normals(mean, modes, facets, points, weights, turns, shifts):
    """Places and normals (B, N, 3), camera frame, of points (N,) of a mesh that moves.

    The mesh has vertices `mean` (S, 3) and `modes` (P, S, 3), and is moved by `weights` (B, P),
    rotations (B, 3, 3) and translations (B, 3).
    """
    count, number = len(weights), len(points)
    at, normals = np.empty((count, number, 3)), np.empty((count, number, 3))
    moved = np.empty(mean.shape)
    for b in range(count):
        moved[:] = mean
        for p in range(len(modes)):
            w = weights[b, p]
            for s in range(len(mean)):
                for i in range(3):
                    moved[s, i] += w * modes[p, s, i]
        across = unit_normals(moved, facets)
        for n in range(number):
            s = points[n]
            for i in range(3):
                turn = turns[b, i]
                normals[b, n, i] = (
                    turn[0] * across[s, 0] + turn[1] * across[s, 1] + turn[2] * across[s, 2]
                )
                at[b, n, i] = shifts[b, i] + (
                    turn[0] * moved[s, 0] + turn[1] * moved[s, 1] + turn[2] * moved[s, 2]
                )
    return at, normals


@numba.njit(**LOOP, error_model="numpy")
def sampled(picture, pixels):
    """A picture (h, w, 3) between its pixels, at (B, N, 2); its border beyond it."""
    height, width = picture.shape[:2]
    out = np.empty((*pixels.shape[:2], 3))
    for b in range(pixels.shape[0]):
        for n in range(pixels.shape[1]):
            if not np.isfinite(pixels[b, n].sum()):
                out[b, n] = np.nan
                continue
            x = min(max(pixels[b, n, 0], 0.0), width - 1.001)
            y = min(max(pixels[b, n, 1], 0.0), height - 1.001)
            i, j = int(x), int(y)
            u, v = x - i, y - j
            for c in range(3):
                above = (1 - u) * picture[j, i, c] + u * picture[j, i + 1, c]
                below = (1 - u) * picture[j + 1, i, c] + u * picture[j + 1, i + 1, c]
                out[b, n, c] = (1 - v) * above + v * below
    return out


@numba.njit(**LOOP, error_model="numpy")
def cauchy_roots(off, tail, nats):
    """Signed roots of half of Cauchy's -log of deviations, `nats` each; of (B, K)."""
    out = np.empty(off.shape)
    for b in range(off.shape[0]):
        for k in range(off.shape[1]):
            far = tail * np.sqrt(0.5 * nats * np.log1p((off[b, k] / tail) ** 2))
            out[b, k] = far if off[b, k] > 0 else -far
    return out
