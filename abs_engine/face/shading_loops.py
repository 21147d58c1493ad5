"""Loops over the points of shaded skin, compiled: see `shading`."""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

import numba
import numpy as np

from abs_engine.core.compiled import LOOP


@numba.njit(**LOOP, error_model="numpy")
def normals_and_slopes(vertices, modes, facets, points):
    """Normals (N, 3) of points (N,) of a mesh, and how they change with its modes (P, 3 N).

    The mesh has vertices (S, 3) and modes (P, S, 3). Normals are as long as twice the area of the
    facets around them.
    """
    count, number = len(modes), len(points)
    place = np.full(len(vertices), -1)
    for n in range(number):
        place[points[n]] = n
    across, turning = np.zeros((number, 3)), np.zeros((count, 3 * number))
    for f in range(len(facets)):
        a, b, c = facets[f]
        own = place[a], place[b], place[c]
        if max(own) < 0:
            continue
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            bj, bk = vertices[b, j] - vertices[a, j], vertices[b, k] - vertices[a, k]
            cj, ck = vertices[c, j] - vertices[a, j], vertices[c, k] - vertices[a, k]
            for n in own:
                if n >= 0:
                    across[n, i] += bj * ck - bk * cj
            for p in range(count):
                mode = modes[p]
                slope = (mode[b, j] - mode[a, j]) * ck - (mode[b, k] - mode[a, k]) * cj
                slope += bj * (mode[c, k] - mode[a, k]) - bk * (mode[c, j] - mode[a, j])
                for n in own:
                    if n >= 0:
                        turning[p, 3 * n + i] += slope
    return across, turning


@numba.njit(**LOOP, error_model="numpy")
def turned(moved, across, turns, shifts):
    """Places and unit normals (B, N, 3), camera frame, of points and normals (B, 3 N), head frame.

    They are turned by (B, 3, 3), and the points moved by (B, 3).
    """
    count, number = len(moved), moved.shape[1] // 3
    at, normals = np.empty((count, number, 3)), np.empty((count, number, 3))
    for b in range(count):
        for n in range(number):
            x, y, z = moved[b, 3 * n], moved[b, 3 * n + 1], moved[b, 3 * n + 2]
            u, v, w = across[b, 3 * n], across[b, 3 * n + 1], across[b, 3 * n + 2]
            length = np.sqrt(u * u + v * v + w * w)
            share = 1.0 / length if length > 0 else 0.0
            for i in range(3):
                turn = turns[b, i]
                at[b, n, i] = shifts[b, i] + (turn[0] * x + turn[1] * y + turn[2] * z)
                normals[b, n, i] = share * (turn[0] * u + turn[1] * v + turn[2] * w)
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
