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

SUBPIXEL_BITS = 8
SUBPIXEL = 1 << SUBPIXEL_BITS
GUARD = 4.0e6 * SUBPIXEL  # farther out, coordinates are clamped so that int64 cannot overflow
FACET_BITS = 26
LAST_FACET = (1 << FACET_BITS) - 1
TILE = 8  # pixels a side, of what may hide a facet
NEARNESS = 2.0**36  # of the near plane; nearness is proportional to 1/w

UNDRAWN = np.float32(-1e30)  # texture coordinate where nothing is drawn, as targets.FAR_AWAY


@numba.njit(cache=True, nogil=True, fastmath={"contract"})
def _to_pixel(x, inverse_w, size):
    """Clip x or y to snapped 1/256 pixel integers (pixel centres at integers)."""
    half = 0.5 * size * SUBPIXEL
    at = x * inverse_w * half + (half - 0.5 * SUBPIXEL)
    at = at if at < GUARD else GUARD
    at = at if at > -GUARD else -GUARD
    return np.int64(np.floor(at + 0.5))


@numba.njit(cache=True, nogil=True, fastmath={"contract"})
def snapped(x, inverse_w, size):
    """Clip x or y as the device coordinate, -1 to 1, of the 1/256 pixel that `_fill` sees."""
    return (_to_pixel(x, inverse_w, size) + 0.5 * SUBPIXEL) / (0.5 * size * SUBPIXEL) - 1.0


@numba.njit(cache=True, nogil=True)
def _edge_bias(dx, dy):
    """0 for a top or left edge, which owns its pixels, else -1 (interior on the positive side)."""
    return 0 if dy < 0 or (dy == 0 and dx > 0) else -1


@numba.njit(cache=True, nogil=True)
def _box(x0, y0, x1, y1, x2, y2, width, height):
    """The pixels whose centres lie in a triangle's bounding box: left, right, top, bottom."""
    left = max((min(x0, x1, x2) + SUBPIXEL - 1) >> SUBPIXEL_BITS, 0)
    right = min(max(x0, x1, x2) >> SUBPIXEL_BITS, width - 1)
    top = max((min(y0, y1, y2) + SUBPIXEL - 1) >> SUBPIXEL_BITS, 0)
    bottom = min(max(y0, y1, y2) >> SUBPIXEL_BITS, height - 1)
    return left, right, top, bottom


@numba.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
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


@numba.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
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


@numba.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
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


@numba.njit(cache=True, nogil=True)
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


@numba.njit(cache=True, nogil=True)
def _hidden(tiles, across, left, right, top, bottom, nearest):
    """Whether all that is drawn in the tiles of a box of pixels is nearer than `nearest`."""
    for j in range(top // TILE, bottom // TILE + 1):
        for i in range(left // TILE, right // TILE + 1):
            if tiles[np.uint64(j * across + i)] <= nearest:
                return False
    return True


@numba.njit(cache=True, nogil=True, error_model="numpy")
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


@numba.njit(cache=True, nogil=True, error_model="numpy")
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


@numba.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
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


@numba.njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
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
        planes[f, :] = 0.0
        planes[f, 2], planes[f, 5], planes[f, 8] = 1.0, uv[a, 0], uv[a, 1]
        return
    planes[f, 0], planes[f, 1], planes[f, 2] = tx, ty, tw
    for k in range(2):
        s0, s1, s2 = np.float64(uv[a, k]), np.float64(uv[b, k]), np.float64(uv[c, k])
        planes[f, 3 + 3 * k] = ax * s0 + bx * s1 + cx * s2
        planes[f, 4 + 3 * k] = ay * s0 + by * s1 + cy * s2
        planes[f, 5 + 3 * k] = aw * s0 + bw * s1 + cw * s2
