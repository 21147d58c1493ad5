"""Loops of the CPU rasteriser, compiled by numba.

Coverage follows OpenGL: vertices are snapped to 1/256 pixel, edges are evaluated in integers with
the top-left rule, so facets that share an edge neither overlap nor leave a gap.

The z-buffer holds one integer key for each pixel: nearness in the high bits, and below them the
facets counted backwards. The largest key wins, so the nearer facet does, and of two at the same
depth the first; an empty pixel's key is nearness at the far plane, so what is beyond loses to it.
"""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

import numba
import numpy as np

from abs_engine.core.compiled import INNER

SUBPIXEL_BITS = 8
SUBPIXEL = 1 << SUBPIXEL_BITS
GUARD = 4.0e6 * SUBPIXEL  # farther out, coordinates are clamped so that int64 cannot overflow
FACET_BITS = 26
LAST_FACET = (1 << FACET_BITS) - 1
TILE = 8  # pixels a side, of what may hide a facet
NEARNESS = 2.0**36  # of the near plane; nearness is proportional to 1/w


@numba.njit(**INNER, fastmath={"contract"})
def _to_pixel(x, inverse_w, size):
    """Clip x or y to snapped 1/256 pixel integers (pixel centres at integers)."""
    half = 0.5 * size * SUBPIXEL
    at = x * inverse_w * half + (half - 0.5 * SUBPIXEL)
    at = at if at < GUARD else GUARD
    at = at if at > -GUARD else -GUARD
    return np.int64(np.floor(at + 0.5))


@numba.njit(**INNER, fastmath={"contract"})
def snapped(x, inverse_w, size):
    """Clip x or y as the device coordinate, -1 to 1, of the 1/256 pixel that `_fill` sees."""
    return (_to_pixel(x, inverse_w, size) + 0.5 * SUBPIXEL) / (0.5 * size * SUBPIXEL) - 1.0


@numba.njit(**INNER)
def _edge_bias(dx, dy):
    """0 for a top or left edge, which owns its pixels, else -1 (interior on the positive side)."""
    return 0 if dy < 0 or (dy == 0 and dx > 0) else -1


@numba.njit(**INNER)
def _box(x0, y0, x1, y1, x2, y2, width, height):
    """The pixels whose centres lie in a triangle's bounding box: left, right, top, bottom."""
    left = max((min(x0, x1, x2) + SUBPIXEL - 1) >> SUBPIXEL_BITS, 0)
    right = min(max(x0, x1, x2) >> SUBPIXEL_BITS, width - 1)
    top = max((min(y0, y1, y2) + SUBPIXEL - 1) >> SUBPIXEL_BITS, 0)
    bottom = min(max(y0, y1, y2) >> SUBPIXEL_BITS, height - 1)
    return left, right, top, bottom


@numba.njit(**INNER, error_model="numpy", fastmath={"contract"})
def _fill(x0, y0, q0, x1, y1, q1, x2, y2, q2, facet, cull, width, height, keys):
    """Fill one snapped triangle; q is nearness. `keys` is flat, row after row."""
    area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
    if area == 0 or (cull and area > 0):
        return  # y is down here: what is counter-clockwise to a viewer has a negative area
    if area < 0:
        x1, y1, q1, x2, y2, q2 = x2, y2, q2, x1, y1, q1
        area = -area
    left, right, top, bottom = _box(x0, y0, x1, y1, x2, y2, width, height)
    if left > right or top > bottom:
        return
    _fill_box(
        x0, y0, q0, x1, y1, q1, x2, y2, q2, area, left, right, top, bottom, facet, width, keys
    )


@numba.njit(**INNER, error_model="numpy", fastmath={"contract"})
def _fill_box(
    x0, y0, q0, x1, y1, q1, x2, y2, q2, area, left, right, top, bottom, facet, width, keys
):
    """Fill a triangle of positive area within a box of pixels."""
    px, py = left * SUBPIXEL, top * SUBPIXEL
    row0 = (x2 - x1) * (py - y1) - (y2 - y1) * (px - x1)
    row1 = (x0 - x2) * (py - y2) - (y0 - y2) * (px - x2)
    row2 = (x1 - x0) * (py - y0) - (y1 - y0) * (px - x0)
    step0, step1, step2 = (y1 - y2) * SUBPIXEL, (y2 - y0) * SUBPIXEL, (y0 - y1) * SUBPIXEL
    down0, down1, down2 = (x2 - x1) * SUBPIXEL, (x0 - x2) * SUBPIXEL, (x1 - x0) * SUBPIXEL
    scale = 1.0 / area
    q1, q2 = (q1 - q0) * scale, (q2 - q0) * scale
    row_q = q0 + row1 * q1 + row2 * q2
    step_q, down_q = step1 * q1 + step2 * q2, down1 * q1 + down2 * q2
    row0 += _edge_bias(x2 - x1, y2 - y1)
    row1 += _edge_bias(x0 - x2, y0 - y2)
    row2 += _edge_bias(x1 - x0, y1 - y0)
    low = LAST_FACET - facet
    for y in range(top, bottom + 1):
        e0, e1, e2, q = row0, row1, row2, row_q
        for x in range(left, right + 1):
            at = np.uint64(y * width + x)  # unsigned, so that numba looks for no negative index
            old = keys[at]
            key = (np.int64(q) << FACET_BITS) | low
            # No branch: whether a pixel is inside is not to be predicted.
            keys[at] = key if ((e0 | e1 | e2) >= 0) & (key > old) else old
            e0 += step0
            e1 += step1
            e2 += step2
            q += step_q
        row0 += down0
        row1 += down1
        row2 += down2
        row_q += down_q


@numba.njit(**INNER, error_model="numpy", fastmath={"contract"})
def rasterise(clip, faces, order, first, near, far, cull, keys, facet):
    """Z-buffer all facets.

    What is drawn does not depend on the order. Once the first ones are drawn, each of the others is
    left out where all that it might cover is nearer.

    Parameters
    ----------
    clip : (V, 4) float32
    faces : (F, 3) int32, F at most 2^26
    order : (F,) int32
        Which facet is drawn when.
    first : int
        How many of these are drawn without a look at what lies before them.
    near, far : float
        Facets are cut where w falls below `near`; pixels beyond `far` are not drawn. mm.
    cull : bool
    keys : (H * W,) int64, out; see the module
    facet : (H, W) int32, out; facet index + 1
    """
    height, width = facet.shape
    n = clip.shape[0]
    x, y, q = np.empty(n, np.int64), np.empty(n, np.int64), np.empty(n, np.float64)
    for i in range(n):
        w = np.float64(clip[i, 3])
        cut = not w >= near
        inverse = 1.0 / (near if cut else w)
        x[i] = _to_pixel(np.float64(clip[i, 0]), inverse, width)
        y[i] = _to_pixel(np.float64(clip[i, 1]), inverse, height)
        q[i] = -1.0 if cut else NEARNESS * near * inverse
    empty = (np.int64(NEARNESS * near / far) << FACET_BITS) | LAST_FACET
    keys[:] = empty
    across, down = (width + TILE - 1) // TILE, (height + TILE - 1) // TILE
    tiles = np.empty(across * down, np.int64)
    for k in range(faces.shape[0]):
        if k == first:
            _farthest(keys, width, height, tiles)
        f = np.uint32(order[k])
        a, b, c = np.uint32(faces[f, 0]), np.uint32(faces[f, 1]), np.uint32(faces[f, 2])
        q0, q1, q2 = q[a], q[b], q[c]
        if q0 > 0 and q1 > 0 and q2 > 0:
            x0, y0, x1, y1, x2, y2 = x[a], y[a], x[b], y[b], x[c], y[c]
            area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
            if area == 0 or (cull and area > 0):
                continue
            left, right, top, bottom = _box(x0, y0, x1, y1, x2, y2, width, height)
            if left > right or top > bottom:
                continue
            if k >= first:
                nearest = np.int64(max(q0, q1, q2)) + 2  # and what rounding may add in between
                if _hidden(tiles, across, left, right, top, bottom, nearest):
                    continue
            if area < 0:
                x1, y1, q1, x2, y2, q2 = x2, y2, q2, x1, y1, q1
                area = -area
            _fill_box(
                x0, y0, q0, x1, y1, q1, x2, y2, q2, area, left, right, top, bottom, np.int64(f),
                width, keys,
            )  # fmt: skip
        elif q0 > 0 or q1 > 0 or q2 > 0:
            _fill_clipped(clip, a, b, c, near, np.int64(f), cull, width, height, keys)
    for i in range(height):
        for j in range(width):
            key = keys[i * width + j]
            facet[i, j] = 0 if key == empty else LAST_FACET + 1 - (key & LAST_FACET)


@numba.njit(**INNER)
def _farthest(keys, width, height, tiles):
    """The least nearness of the pixels in each tile so far."""
    at = 0
    for top in range(0, height, TILE):
        for left in range(0, width, TILE):
            least = keys[top * width + left]
            for y in range(top, min(top + TILE, height)):
                for x in range(left, min(left + TILE, width)):
                    least = min(least, keys[np.uint64(y * width + x)])
            tiles[at] = least >> FACET_BITS
            at += 1


@numba.njit(**INNER)
def _hidden(tiles, across, left, right, top, bottom, nearest):
    """Whether all that is drawn in the tiles of a box of pixels is nearer than `nearest`."""
    for j in range(top // TILE, bottom // TILE + 1):
        for i in range(left // TILE, right // TILE + 1):
            if tiles[np.uint64(j * across + i)] <= nearest:
                return False
    return True


@numba.njit(**INNER, error_model="numpy")
def _fill_clipped(clip, a, b, c, near, facet, cull, width, height, keys):
    """Cut a facet at the near plane (Sutherland-Hodgman) and fill the one or two pieces."""
    corners = (a, b, c)
    x, y = np.empty(4, np.int64), np.empty(4, np.int64)
    q = np.empty(4, np.float64)
    n = 0
    for k in range(3):
        i, j = corners[k], corners[(k + 1) % 3]
        wi, wj = np.float64(clip[i, 3]), np.float64(clip[j, 3])
        if wi >= near:
            x[n] = _to_pixel(np.float64(clip[i, 0]), 1.0 / wi, width)
            y[n] = _to_pixel(np.float64(clip[i, 1]), 1.0 / wi, height)
            q[n] = NEARNESS * near / wi
            n += 1
        if (wi >= near) != (wj >= near):
            s = (near - wi) / (wj - wi)
            x[n] = _to_pixel(clip[i, 0] + s * (clip[j, 0] - clip[i, 0]), 1.0 / near, width)
            y[n] = _to_pixel(clip[i, 1] + s * (clip[j, 1] - clip[i, 1]), 1.0 / near, height)
            q[n] = NEARNESS
            n += 1
    for k in range(1, n - 1):
        _fill(
            x[0], y[0], q[0], x[k], y[k], q[k], x[k + 1], y[k + 1], q[k + 1],
            facet, cull, width, height, keys,
        )  # fmt: skip
