"""Loops of the CPU rasteriser, compiled by numba.

Coverage follows OpenGL: vertices are snapped to 1/256 pixel, edges are evaluated in integers with
the top-left rule, so facets that share an edge neither overlap nor leave a gap.
"""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

import numba
import numpy as np

SUBPIXEL = 256
GUARD = 4.0e6  # pixels; farther out, coordinates are clamped so that int64 cannot overflow


@numba.njit(cache=True, nogil=True)
def _to_pixels(x, y, w, width, height):
    """Clip x, y, w to snapped 1/256 pixel integers (pixel centres at integers)."""
    px = (x / w + 1.0) * 0.5 * width - 0.5
    py = (y / w + 1.0) * 0.5 * height - 0.5
    px = min(max(px, -GUARD), GUARD)
    py = min(max(py, -GUARD), GUARD)
    return np.int64(np.floor(px * SUBPIXEL + 0.5)), np.int64(np.floor(py * SUBPIXEL + 0.5))


@numba.njit(cache=True, nogil=True)
def _edge_bias(dx, dy):
    """0 for a top or left edge, which owns its pixels, else -1 (interior on the positive side)."""
    return 0 if dy < 0 or (dy == 0 and dx > 0) else -1


@numba.njit(cache=True, nogil=True)
def _fill(x0, y0, q0, x1, y1, q1, x2, y2, q2, ident, cull, inverse_depth, facet):
    """Fill one snapped triangle; q = 1/w, the largest wins, the first wins ties."""
    height, width = facet.shape
    area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
    if area == 0 or (cull and area > 0):
        return  # y is down here: what is counter-clockwise to a viewer has a negative area
    if area < 0:
        x1, y1, q1, x2, y2, q2 = x2, y2, q2, x1, y1, q1
        area = -area
    left = max(-((-min(x0, x1, x2)) // SUBPIXEL), 0)
    right = min(max(x0, x1, x2) // SUBPIXEL, width - 1)
    top = max(-((-min(y0, y1, y2)) // SUBPIXEL), 0)
    bottom = min(max(y0, y1, y2) // SUBPIXEL, height - 1)
    if left > right or top > bottom:
        return
    px, py = left * SUBPIXEL, top * SUBPIXEL
    row0 = (x2 - x1) * (py - y1) - (y2 - y1) * (px - x1) + _edge_bias(x2 - x1, y2 - y1)
    row1 = (x0 - x2) * (py - y2) - (y0 - y2) * (px - x2) + _edge_bias(x0 - x2, y0 - y2)
    row2 = (x1 - x0) * (py - y0) - (y1 - y0) * (px - x0) + _edge_bias(x1 - x0, y1 - y0)
    step0, step1, step2 = (y1 - y2) * SUBPIXEL, (y2 - y0) * SUBPIXEL, (y0 - y1) * SUBPIXEL
    down0, down1, down2 = (x2 - x1) * SUBPIXEL, (x0 - x2) * SUBPIXEL, (x1 - x0) * SUBPIXEL
    scale = 1.0 / area
    qx = (step1 * (q1 - q0) + step2 * (q2 - q0)) * scale
    for y in range(top, bottom + 1):
        e0, e1, e2 = row0, row1, row2
        q = q0 + (e1 * (q1 - q0) + e2 * (q2 - q0)) * scale
        for x in range(left, right + 1):
            if (e0 | e1 | e2) >= 0 and q > inverse_depth[y, x]:
                inverse_depth[y, x] = q
                facet[y, x] = ident
            e0 += step0
            e1 += step1
            e2 += step2
            q += qx
        row0 += down0
        row1 += down1
        row2 += down2


@numba.njit(cache=True, nogil=True)
def rasterise(clip, faces, near, cull, inverse_depth, facet):
    """Z-buffer all facets.

    Parameters
    ----------
    clip : (V, 4) float32
    faces : (F, 3) int32
    near : float
        Facets are cut where w falls below it, mm.
    cull : bool
    inverse_depth : (H, W) float32, out; 1/w, 0 in the background
    facet : (H, W) int32, out; facet index + 1
    """
    height, width = facet.shape
    n = clip.shape[0]
    x, y = np.empty(n, np.int64), np.empty(n, np.int64)
    q = np.empty(n, np.float64)
    for i in range(n):
        w = np.float64(clip[i, 3])
        if w >= near:
            x[i], y[i] = _to_pixels(np.float64(clip[i, 0]), np.float64(clip[i, 1]), w, width, height)
            q[i] = 1.0 / w
        else:
            q[i] = -1.0
    inverse_depth[:] = 0
    facet[:] = 0
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        if q[a] > 0 and q[b] > 0 and q[c] > 0:
            _fill(
                x[a], y[a], q[a], x[b], y[b], q[b], x[c], y[c], q[c],
                f + 1, cull, inverse_depth, facet,
            )  # fmt: skip
        elif q[a] > 0 or q[b] > 0 or q[c] > 0:
            _fill_clipped(clip, a, b, c, near, f + 1, cull, inverse_depth, facet)


@numba.njit(cache=True, nogil=True)
def _fill_clipped(clip, a, b, c, near, ident, cull, inverse_depth, facet):
    """Cut a facet at the near plane (Sutherland-Hodgman) and fill the one or two pieces."""
    height, width = facet.shape
    corners = (a, b, c)
    x, y = np.empty(4, np.int64), np.empty(4, np.int64)
    q = np.empty(4, np.float64)
    n = 0
    for k in range(3):
        i, j = corners[k], corners[(k + 1) % 3]
        wi, wj = np.float64(clip[i, 3]), np.float64(clip[j, 3])
        if wi >= near:
            x[n], y[n] = _to_pixels(
                np.float64(clip[i, 0]), np.float64(clip[i, 1]), wi, width, height
            )
            q[n] = 1.0 / wi
            n += 1
        if (wi >= near) != (wj >= near):
            s = (near - wi) / (wj - wi)
            x[n], y[n] = _to_pixels(
                clip[i, 0] + s * (clip[j, 0] - clip[i, 0]),
                clip[i, 1] + s * (clip[j, 1] - clip[i, 1]),
                near, width, height,
            )  # fmt: skip
            q[n] = 1.0 / near
            n += 1
    for k in range(1, n - 1):
        _fill(
            x[0], y[0], q[0], x[k], y[k], q[k], x[k + 1], y[k + 1], q[k + 1],
            ident, cull, inverse_depth, facet,
        )  # fmt: skip


@numba.njit(cache=True, nogil=True)
def _weights(clip, faces, f, px, py, width, height):
    """Perspective-correct barycentrics and depth of facet `f` at a pixel.

    Homogeneous rasterisation: the weights solve sum b_i (x_i, y_i, w_i) ~ (X, Y, 1), which also
    holds for facets that cross the near plane.
    """
    X = (px + 0.5) * 2.0 / width - 1.0
    Y = (py + 0.5) * 2.0 / height - 1.0
    a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
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


@numba.njit(cache=True, nogil=True)
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


@numba.njit(cache=True, nogil=True)
def shade(clip, faces, uv, texture, facet, depth, bary, rgb):
    """Fill depth (H, W), barycentrics and colour (H, W, 3), all float32, where `facet` > 0."""
    height, width = facet.shape
    for y in range(height):
        for x in range(width):
            f = facet[y, x] - 1
            if f < 0:
                continue
            b0, b1, b2, z = _weights(clip, faces, f, x, y, width, height)
            depth[y, x] = z
            bary[y, x, 0], bary[y, x, 1], bary[y, x, 2] = b0, b1, b2
            a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
            u = b0 * uv[a, 0] + b1 * uv[b, 0] + b2 * uv[c, 0]
            v = b0 * uv[a, 1] + b1 * uv[b, 1] + b2 * uv[c, 1]
            rgb[y, x, 0], rgb[y, x, 1], rgb[y, x, 2] = _texel(texture, u, v)


@numba.njit(cache=True, nogil=True)
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


@numba.njit(cache=True, nogil=True)
def sum_colour_error(clip, faces, uv, texture, facet, target):
    """Sum over drawn pixels of the squared difference to the normalised frame, and their number."""
    height, width = facet.shape
    total, pixels = 0.0, 0
    for y in range(height):
        for x in range(width):
            f = facet[y, x] - 1
            if f < 0:
                continue
            b0, b1, b2, _ = _weights(clip, faces, f, x, y, width, height)
            a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
            u = b0 * uv[a, 0] + b1 * uv[b, 0] + b2 * uv[c, 0]
            v = b0 * uv[a, 1] + b1 * uv[b, 1] + b2 * uv[c, 1]
            r, g, bl = _texel(texture, u, v)
            s = 1.0 / (r + g + bl + 3.0)
            dr = (r + 1.0) * s - target[y, x, 0]
            dg = (g + 1.0) * s - target[y, x, 1]
            db = (bl + 1.0) * s - target[y, x, 2]
            total += dr * dr + dg * dg + db * db
            pixels += 1
    return total, pixels
