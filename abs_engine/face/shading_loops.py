"""Loops over the points of shaded skin, compiled: see `shading`."""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

import numba
import numpy as np

from abs_engine.core.compiled import LOOP


@numba.njit(**LOOP, error_model="numpy")
def normals_and_slopes(vertices, modes, facets, points):
    """Normals (3, N) of points (N,) of a mesh, and how they change with its modes (P, 3, N).

    The mesh has vertices (S, 3) and modes (P, S, 3). Normals are as long as twice the area of the
    facets around them.
    """
    count, number = len(modes), len(points)
    place = np.full(len(vertices), -1)
    for n in range(number):
        place[points[n]] = n
    across, turning = np.zeros((3, number)), np.zeros((count, 3, number))
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
                    across[i, n] += bj * ck - bk * cj
            for p in range(count):
                mode = modes[p]
                slope = (mode[b, j] - mode[a, j]) * ck - (mode[b, k] - mode[a, k]) * cj
                slope += bj * (mode[c, k] - mode[a, k]) - bk * (mode[c, j] - mode[a, j])
                for n in own:
                    if n >= 0:
                        turning[p, i, n] += slope
    return across, turning


@numba.njit(**LOOP, error_model="numpy")
def turned(moved, across, turns, shifts):
    """Places and unit normals (B, N, 3), camera frame, of points and normals (B, 3, N), head frame.

    They are turned by (B, 3, 3), and the points moved by (B, 3).
    """
    count, _, number = moved.shape
    at, normals = np.empty((count, number, 3)), np.empty((count, number, 3))
    for b in range(count):
        for n in range(number):
            x, y, z = moved[b, 0, n], moved[b, 1, n], moved[b, 2, n]
            u, v, w = across[b, 0, n], across[b, 1, n], across[b, 2, n]
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
            if not np.isfinite(pixels[b, n, 0] + pixels[b, n, 1]):
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
def uphill(picture, pixels):
    """Slopes (N, 3, 2) of what `sampled` gives at pixels (N, 2), for a pixel in x and in y."""
    height, width = picture.shape[:2]
    out = np.zeros((len(pixels), 3, 2))
    for n in range(len(pixels)):
        x = min(max(pixels[n, 0], 0.0), width - 1.001)
        y = min(max(pixels[n, 1], 0.0), height - 1.001)
        if not np.isfinite(pixels[n, 0] + pixels[n, 1]):
            continue
        i, j = int(x), int(y)
        for c in range(3):
            a, b = picture[j, i, c], picture[j, i + 1, c]
            bent = picture[j + 1, i + 1, c] - picture[j + 1, i, c] - (b - a)
            if x == pixels[n, 0]:
                out[n, c, 0] = b - a + (y - j) * bent
            if y == pixels[n, 1]:
                out[n, c, 1] = picture[j + 1, i, c] - a + (x - i) * bent
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


@numba.njit(**LOOP, error_model="numpy")
def root_slopes(off, tail, nats):
    """Slopes (3, N) of `cauchy_roots` with the deviations (3, N) of one candidate."""
    out = np.empty(off.shape)
    for c in range(3):
        for n in range(off.shape[1]):
            share = (off[c, n] / tail) ** 2
            shrunk = share / np.log1p(share) if share > 1e-12 else 1.0
            out[c, n] = np.sqrt(0.5 * nats * shrunk) / (1.0 + share)
    return out


@numba.njit(**LOOP, error_model="numpy")
def deviation_slopes(
    rises, at, normals, lengths, arms, rotation, along, turning, focal, light, colour, noise
):
    """Slopes (6 + P, 3, N) of the `deviations` of one candidate along its parameters.

    Its points lie at (N, 3), camera frame, and `arms` (N, 3) lead to them from the point that the
    pose turns about. The picture rises by `rises` (N, 3, 2) for a pixel; modes move points and
    normals by (P, 3, N), head frame, whose normals have lengths (N,). The lens's distortion is left
    out.
    """
    number, count = len(at), len(along)
    out = np.empty((6 + count, 3, number))
    moves, turns = np.empty((3, 3, number)), np.empty((3, 3, number))
    for c in range(3):
        k = light[:, c]
        for n in range(number):
            x, y, z = normals[n, 0], normals[n, 1], normals[n, 2]
            px = rises[n, c, 0] * focal[0] / at[n, 2] / noise[c]
            py = rises[n, c, 1] * focal[1] / at[n, 2] / noise[c]
            pz = -(px * at[n, 0] + py * at[n, 1]) / at[n, 2]
            shade = -colour[n, c] / noise[c]
            qx = shade * (k[1] + k[4] * y + k[5] * z + 2 * k[7] * x)
            qy = shade * (k[2] + k[4] * x + k[6] * z - 2 * k[7] * y)
            qz = shade * (k[3] + k[5] * x + k[6] * y + 6 * k[8] * z)
            u, v, w = arms[n, 0], arms[n, 1], arms[n, 2]
            out[0, c, n] = v * pz - w * py + y * qz - z * qy
            out[1, c, n] = w * px - u * pz + z * qx - x * qz
            out[2, c, n] = u * py - v * px + x * qy - y * qx
            out[3, c, n], out[4, c, n], out[5, c, n] = px, py, pz
            outward = x * qx + y * qy + z * qz
            share = 1.0 / lengths[n] if lengths[n] > 0 else 0.0
            qx, qy, qz = qx - outward * x, qy - outward * y, qz - outward * z
            for i in range(3):
                back = rotation[0, i], rotation[1, i], rotation[2, i]
                moves[c, i, n] = back[0] * px + back[1] * py + back[2] * pz
                turns[c, i, n] = share * (back[0] * qx + back[1] * qy + back[2] * qz)
    for p in range(count):
        for c in range(3):
            for n in range(number):  # one number after another, several in a step
                total = moves[c, 0, n] * along[p, 0, n] + turns[c, 0, n] * turning[p, 0, n]
                total += moves[c, 1, n] * along[p, 1, n] + turns[c, 1, n] * turning[p, 1, n]
                total += moves[c, 2, n] * along[p, 2, n] + turns[c, 2, n] * turning[p, 2, n]
                out[6 + p, c, n] = total
    return out


@numba.njit(**LOOP, error_model="numpy")
def as_root_slopes(slopes, shares, forgiven, rising):
    """Turn the slopes (D, 3, N) of deviations into those of their roots, in place.

    What is `forgiven` (3, L, N) is taken out, of which they have `shares` (3, D, L); the rest rises
    as `rising` (3, N) says.
    """
    for p in range(len(slopes)):
        for c in range(3):
            row = slopes[p, c]
            for k in range(forgiven.shape[1]):
                share, basis = shares[c, p, k], forgiven[c, k]
                for n in range(len(row)):
                    row[n] -= share * basis[n]
            for n in range(len(row)):
                row[n] *= rising[c, n]
