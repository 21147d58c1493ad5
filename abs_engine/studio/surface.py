"""Loops over pixels, compiled by numba: what the surface under each pixel is like.

All of them start from the id that was drawn at a pixel. The ray through the pixel's centre, met
with that facet's plane in float64, gives the barycentric weights; everything else follows from
them. Positions are of the ideal camera: lens distortion has moved them already.
"""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

import numba
import numpy as np

from abs_engine.core.compiled import LOOP


@numba.njit(**LOOP, error_model="numpy")
def trace(ids, vertices, faces, inverse, weights, depth):
    """Barycentric weights and depth of every pixel of a facet.

    Parameters
    ----------
    ids : (H, W) uint16, facet + 1
    vertices : (V, 3) float64, camera frame
    faces : (F, 3) int32
    inverse : (3, 3) float64, of the camera matrix
    weights : (H, W, 3) float32, filled; perspective-correct
    depth : (H, W) float64, filled; mm along the optical axis
    """
    for y in range(ids.shape[0]):
        for x in range(ids.shape[1]):
            facet = ids[y, x]
            if facet == 0:
                depth[y, x] = 0.0
                continue
            rx = inverse[0, 0] * x + inverse[0, 1] * y + inverse[0, 2]
            ry = inverse[1, 1] * y + inverse[1, 2]
            a, b, c = faces[facet - 1]
            ax, ay, az = vertices[a, 0], vertices[a, 1], vertices[a, 2]
            bx, by, bz = vertices[b, 0], vertices[b, 1], vertices[b, 2]
            cx, cy, cz = vertices[c, 0], vertices[c, 1], vertices[c, 2]
            # r . (b x c) and so on: the point l r = wa a + wb b + wc c
            wa = rx * (by * cz - bz * cy) + ry * (bz * cx - bx * cz) + (bx * cy - by * cx)
            wb = rx * (cy * az - cz * ay) + ry * (cz * ax - cx * az) + (cx * ay - cy * ax)
            wc = rx * (ay * bz - az * by) + ry * (az * bx - ax * bz) + (ax * by - ay * bx)
            total = wa + wb + wc
            # Seen edge-on, the centre of the pixel may lie a rounding error outside of the facet.
            wa, wb, wc = max(wa / total, 0.0), max(wb / total, 0.0), max(wc / total, 0.0)
            total = wa + wb + wc
            weights[y, x, 0], weights[y, x, 1] = wa / total, wb / total
            weights[y, x, 2] = wc / total
            depth[y, x] = (wa * az + wb * bz + wc * cz) / total


@numba.njit(**LOOP, error_model="numpy")
def blend(ids, weights, faces, values, out):
    """Values (V, C) of the vertices, interpolated; out (H, W, C), 0 where ids are."""
    channels = values.shape[1]
    for y in range(ids.shape[0]):
        for x in range(ids.shape[1]):
            facet = ids[y, x]
            for k in range(channels):
                if facet == 0:
                    out[y, x, k] = 0.0
                else:
                    a, b, c = faces[facet - 1]
                    out[y, x, k] = (
                        weights[y, x, 0] * values[a, k]
                        + weights[y, x, 1] * values[b, k]
                        + weights[y, x, 2] * values[c, k]
                    )


@numba.njit(**LOOP, error_model="numpy")
def sample(ids, uv, level, texels, starts, sides, out):
    """Colours (H, W, 3) uint8 of a square texture, bilinear, 0 where ids are.

    Parameters
    ----------
    ids : (H, W) uint16
    uv : (H, W, 2) float32, v down
    level : (H, W) uint8
        Which halving of the texture is taken.
    texels : (N, 3) float32
        All halvings one after the other, rows first.
    starts, sides : (L,) int64
        Where each begins, and its side in pixels.
    out : (H, W, 3) uint8, filled
    """
    for y in range(ids.shape[0]):
        for x in range(ids.shape[1]):
            if ids[y, x] == 0:
                out[y, x, 0], out[y, x, 1], out[y, x, 2] = 0, 0, 0
                continue
            side, start = sides[level[y, x]], starts[level[y, x]]
            u = min(max(uv[y, x, 0] * side - 0.5, 0.0), side - 1.0)
            v = min(max(uv[y, x, 1] * side - 0.5, 0.0), side - 1.0)
            left, top = min(int(u), side - 2), min(int(v), side - 2)
            right, down = u - left, v - top
            corner = start + top * side + left
            for k in range(3):
                upper = (1 - right) * texels[corner, k] + right * texels[corner + 1, k]
                lower = (1 - right) * texels[corner + side, k]
                lower += right * texels[corner + side + 1, k]
                out[y, x, k] = np.uint8((1 - down) * upper + down * lower + 0.5)


@numba.njit(**LOOP, error_model="numpy")
def hidden(points, vertices, pixels, faces, weld, owner, clearance):
    """Mask (N,) of the points that something in front of them hides from the camera.

    Parameters
    ----------
    points : (N, 3) float64
        Pixel x and y, and depth, mm.
    vertices : (V, 3) float64, camera frame
    pixels : (V, 2) float64, where they project
    faces : (F, 3) int32
        Counter-clockwise from outside; those that turn their back are not seen and hide nothing.
    weld : (V,) int32
        Copies of a vertex share a number.
    owner : (N,) int64
        The welded vertex that each point is, whose own facets do not hide it; or -1.
    clearance : float
        mm by which a facet must be nearer.
    """
    out = np.zeros(len(points), np.bool_)
    for f in range(len(faces)):
        a, b, c = faces[f]
        if vertices[a, 2] <= 0 or vertices[b, 2] <= 0 or vertices[c, 2] <= 0:
            continue
        ax, ay, bx, by = pixels[a, 0], pixels[a, 1], pixels[b, 0], pixels[b, 1]
        cx, cy = pixels[c, 0], pixels[c, 1]
        area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        if area >= 0:  # y is down: what faces the camera has a negative area
            continue
        left, right = min(ax, bx, cx), max(ax, bx, cx)
        top, bottom = min(ay, by, cy), max(ay, by, cy)
        for i in range(len(points)):
            x, y = points[i, 0], points[i, 1]
            if out[i] or x < left or x > right or y < top or y > bottom:
                continue
            if owner[i] >= 0 and (
                weld[a] == owner[i] or weld[b] == owner[i] or weld[c] == owner[i]
            ):
                continue
            wa = ((bx - x) * (cy - y) - (cx - x) * (by - y)) / area
            wb = ((cx - x) * (ay - y) - (ax - x) * (cy - y)) / area
            wc = 1 - wa - wb
            if wa < 0 or wb < 0 or wc < 0:
                continue
            nearness = wa / vertices[a, 2] + wb / vertices[b, 2] + wc / vertices[c, 2]
            if 1 / nearness < points[i, 2] - clearance:
                out[i] = True
    return out
