"""Loops over the pixels of what was rasterised, compiled by numba."""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

import numba
import numpy as np

from abs_engine.core.compiled import INNER, LOOP

UNDRAWN = np.float32(-1e30)  # texture coordinate where nothing is drawn, as targets.FAR_AWAY


@numba.njit(**INNER, error_model="numpy")
def _weights(clip, faces, f, px, py, width, height):
    """Perspective-correct barycentrics and depth of facet `f` at a pixel.

    Homogeneous rasterisation: the weights solve sum b_i (x_i, y_i, w_i) ~ (X, Y, 1), which also
    holds for facets that cross the near plane.
    """
    X = (px + 0.5) * 2.0 / width - 1.0
    Y = (py + 0.5) * 2.0 / height - 1.0
    a, b, c = np.uint32(faces[f, 0]), np.uint32(faces[f, 1]), np.uint32(faces[f, 2])
    w0, w1, w2 = np.float64(clip[a, 3]), np.float64(clip[b, 3]), np.float64(clip[c, 3])
    x0, y0 = clip[a, 0] - X * w0, clip[a, 1] - Y * w0
    x1, y1 = clip[b, 0] - X * w1, clip[b, 1] - Y * w1
    x2, y2 = clip[c, 0] - X * w2, clip[c, 1] - Y * w2
    b0, b1, b2 = x1 * y2 - x2 * y1, x2 * y0 - x0 * y2, x0 * y1 - x1 * y0
    total = b0 + b1 + b2
    if total == 0.0:
        return 1.0, 0.0, 0.0, w0
    inverse = 1.0 / total
    b0, b1, b2 = b0 * inverse, b1 * inverse, b2 * inverse
    return b0, b1, b2, b0 * w0 + b1 * w1 + b2 * w2


@numba.njit(**INNER)
def _texel(texture, u, v):
    """Bilinear colour, clamped to the edge; pixel = uv * size - 0.5."""
    height, width = texture.shape[0], texture.shape[1]
    x = min(max(u * width - 0.5, 0.0), width - 1.0)
    y = min(max(v * height - 0.5, 0.0), height - 1.0)
    i, j = np.uint64(x), np.uint64(y)  # unsigned, so that numba checks for no negative index
    i2, j2 = np.uint64(min(x + 1.0, width - 1.0)), np.uint64(min(y + 1.0, height - 1.0))
    fx, fy = x - np.float64(i), y - np.float64(j)
    w00, w10, w01, w11 = (1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy
    r = w00 * texture[j, i, 0] + w10 * texture[j, i2, 0]
    r += w01 * texture[j2, i, 0] + w11 * texture[j2, i2, 0]
    g = w00 * texture[j, i, 1] + w10 * texture[j, i2, 1]
    g += w01 * texture[j2, i, 1] + w11 * texture[j2, i2, 1]
    b = w00 * texture[j, i, 2] + w10 * texture[j, i2, 2]
    b += w01 * texture[j2, i, 2] + w11 * texture[j2, i2, 2]
    return r, g, b


@numba.njit(**LOOP)
def shade(clip, faces, uv, texture, facet, depth, bary, rgb):
    """Fill depth (H, W), barycentrics and colour (H, W, 3), all float32, where `facet` > 0."""
    height, width = facet.shape
    for y in range(height):
        for x in range(width):
            if facet[y, x] == 0:
                continue
            f = np.uint32(facet[y, x] - 1)
            b0, b1, b2, z = _weights(clip, faces, f, x, y, width, height)
            depth[y, x] = z
            bary[y, x, 0], bary[y, x, 1], bary[y, x, 2] = b0, b1, b2
            a, b, c = np.uint32(faces[f, 0]), np.uint32(faces[f, 1]), np.uint32(faces[f, 2])
            u = b0 * uv[a, 0] + b1 * uv[b, 0] + b2 * uv[c, 0]
            v = b0 * uv[a, 1] + b1 * uv[b, 1] + b2 * uv[c, 1]
            rgb[y, x, 0], rgb[y, x, 1], rgb[y, x, 2] = _texel(texture, u, v)


@numba.njit(**LOOP)
def outlines(clip, faces, facet, facet_class, shown, depth, bary):
    """Fill the class `shown` (H, W); depth and barycentrics where a neighbour is of another."""
    height, width = facet.shape
    for y in range(height):
        for x in range(width):
            f = facet[y, x] - 1
            shown[y, x] = facet_class[f] if f >= 0 else 0
    for y in range(height):
        for x in range(width):
            f, own = facet[y, x] - 1, shown[y, x]
            if f < 0:
                continue
            left, right = shown[y, max(x - 1, 0)], shown[y, min(x + 1, width - 1)]
            above, below = shown[max(y - 1, 0), x], shown[min(y + 1, height - 1), x]
            if left == own and right == own and above == own and below == own:
                continue
            b0, b1, b2, z = _weights(clip, faces, f, x, y, width, height)
            depth[y, x] = z
            bary[y, x, 0], bary[y, x, 1], bary[y, x, 2] = b0, b1, b2


@numba.njit(**INNER)
def sum_class_maps(facet, facet_class, maps):
    """Sum over drawn pixels of the map of their class, and how many there are."""
    total, pixels = 0.0, 0
    for y in range(facet.shape[0]):
        for x in range(facet.shape[1]):
            f = facet[y, x] - 1
            if f >= 0:
                total += maps[facet_class[f], y, x]
                pixels += 1
    return total, pixels


@numba.njit(**LOOP, error_model="numpy", fastmath={"contract"})
def texture_uv(clip, faces, uv, facet, planes, known, out):
    """Texture coordinates of the drawn pixels: what `shade` interpolates, but much faster.

    The weights of `_weights` are linear in the pixel, so u = U(x, y) / T(x, y) and v likewise,
    with three planes for each facet, which are computed when its first pixel is met.

    Parameters
    ----------
    clip : (V, 4) float32
    faces : (F, 3) int32
    uv : (V, 2) float32
    facet : (H, W) int32
    planes : (F, 9) float64, scratch
    known : (F,) uint8, scratch
    out : (H, W, 2) float32, out; `UNDRAWN` in the background
    """
    height, width = facet.shape
    known[:] = 0
    per_column, per_row = 2.0 / width, 2.0 / height
    for y in range(height):
        Y = (y + 0.5) * per_row - 1.0
        for x in range(width):
            if facet[y, x] == 0:
                out[y, x, 0] = out[y, x, 1] = UNDRAWN
                continue
            f = np.uint32(facet[y, x] - 1)
            if not known[f]:
                _set_planes(clip, faces, uv, f, planes)
                known[f] = 1
            X = (x + 0.5) * per_column - 1.0
            t = 1.0 / (planes[f, 0] * X + planes[f, 1] * Y + planes[f, 2])
            out[y, x, 0] = (planes[f, 3] * X + planes[f, 4] * Y + planes[f, 5]) * t
            out[y, x, 1] = (planes[f, 6] * X + planes[f, 7] * Y + planes[f, 8]) * t


@numba.njit(**INNER, error_model="numpy", fastmath={"contract"})
def _set_planes(clip, faces, uv, f, planes):
    """The planes T, U, V of facet `f` over GL device coordinates; see `texture_uv`."""
    a, b, c = np.uint32(faces[f, 0]), np.uint32(faces[f, 1]), np.uint32(faces[f, 2])
    x0, y0, w0 = np.float64(clip[a, 0]), np.float64(clip[a, 1]), np.float64(clip[a, 3])
    x1, y1, w1 = np.float64(clip[b, 0]), np.float64(clip[b, 1]), np.float64(clip[b, 3])
    x2, y2, w2 = np.float64(clip[c, 0]), np.float64(clip[c, 1]), np.float64(clip[c, 3])
    # b_i of `_weights`, as cross products of the other two corners
    ax, ay, aw = y1 * w2 - y2 * w1, w1 * x2 - w2 * x1, x1 * y2 - x2 * y1
    bx, by, bw = y2 * w0 - y0 * w2, w2 * x0 - w0 * x2, x2 * y0 - x0 * y2
    cx, cy, cw = y0 * w1 - y1 * w0, w0 * x1 - w1 * x0, x0 * y1 - x1 * y0
    tx, ty, tw = ax + bx + cx, ay + by + cy, aw + bw + cw
    if tx == 0.0 and ty == 0.0 and tw == 0.0:  # no area but by snapping: the first corner's
        for k in range(9):
            planes[f, k] = 0.0
        planes[f, 2], planes[f, 5], planes[f, 8] = 1.0, uv[a, 0], uv[a, 1]
        return
    planes[f, 0], planes[f, 1], planes[f, 2] = tx, ty, tw
    for k in range(2):
        s0, s1, s2 = np.float64(uv[a, k]), np.float64(uv[b, k]), np.float64(uv[c, k])
        planes[f, 3 + 3 * k] = ax * s0 + bx * s1 + cx * s2
        planes[f, 4 + 3 * k] = ay * s0 + by * s1 + cy * s2
        planes[f, 5 + 3 * k] = aw * s0 + bw * s1 + cw * s2
