"""Loops over the points of shaded skin, compiled: see `shading`."""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

import numba
import numpy as np

from abs_engine.core.compiled import LOOP
from abs_engine.core.facet_loops import unit_normals


@numba.njit(**LOOP, error_model="numpy")
def places_and_normals(moved, facets, points, turns, shifts):
    """Places and normals (B, N, 3), camera frame, of points (N,) of a mesh that moves.

    The mesh has vertices (B, S, 3), turned by (B, 3, 3) and moved by (B, 3).
    """
    count, number = len(moved), len(points)
    at, normals = np.empty((count, number, 3)), np.empty((count, number, 3))
    for b in range(count):
        across = unit_normals(moved[b], facets)
        for n in range(number):
            s = points[n]
            for i in range(3):
                turn = turns[b, i]
                normals[b, n, i] = (
                    turn[0] * across[s, 0] + turn[1] * across[s, 1] + turn[2] * across[s, 2]
                )
                at[b, n, i] = shifts[b, i] + (
                    turn[0] * moved[b, s, 0] + turn[1] * moved[b, s, 1] + turn[2] * moved[b, s, 2]
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
def deviations(shown, normals, light, colour, noise):
    """Standard deviations (3, B, N) by which points are not as bright as expected in each channel.

    They show (B, N, 3) and have normals (B, N, 3), colours (N, 3) and noise (3,); the light (9, 3)
    is in the order of `harmonics`.
    """
    out = np.empty((3, *shown.shape[:2]))
    for b in range(shown.shape[0]):
        for n in range(shown.shape[1]):
            x, y, z = normals[b, n]
            for c in range(3):
                k = light[:, c]
                falls = k[0] + x * (k[1] + k[4] * y + k[5] * z + k[7] * x) + k[8] * (3 * z * z - 1)
                falls += y * (k[2] + k[6] * z - k[7] * y) + k[3] * z
                out[c, b, n] = (shown[b, n, c] - colour[n, c] * falls) / noise[c]
    return out


@numba.njit(**LOOP, error_model="numpy")
def cauchy_roots(off, tail, nats):
    """Signed roots (B, 3 N) of half of Cauchy's -log of deviations (3, B, N), `nats` each."""
    number = off.shape[2]
    out = np.empty((off.shape[1], 3 * number))
    for c in range(3):
        for b in range(off.shape[1]):
            for n in range(number):
                far = tail * np.sqrt(0.5 * nats * np.log1p((off[c, b, n] / tail) ** 2))
                out[b, c * number + n] = far if off[c, b, n] > 0 else -far
    return out
