"""The pixel terms of `scene.py`, summed over what OpenGL drew, in loops compiled by numba.

On a software rasteriser a fragment shader runs on whole 4x4 blocks for every small triangle that
touches them, about ten lanes for each pixel kept. So there the shader only writes a class or
texture coordinates, and the term is computed once for each pixel, here.
"""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

import numba
import numpy as np

ZERO, HALF, ONE = np.float32(0), np.float32(0.5), np.float32(1)
DRAWN_FROM = np.float32(-1e29)


@numba.njit(cache=True, nogil=True)
def sum_class_maps(classes, maps):
    """Sum of each drawn pixel's map value.

    Parameters
    ----------
    classes : (H, W) int32; 0 is background
    maps : (C, H, W) float32

    Returns
    -------
    tuple of float and int
        The sum, and how many pixels were drawn.
    """
    total, pixels = 0.0, 0
    for y in range(classes.shape[0]):
        for x in range(classes.shape[1]):
            c = classes[y, x]
            if c > 0:
                total += maps[c, y, x]
                pixels += 1
    return total, pixels


@numba.njit(cache=True, nogil=True)
def sum_colour_error(uv, texture, target):
    """Sum of squared differences of luminance-normalised RGB.

    Parameters
    ----------
    uv : (H, W, 2) float32
        Texture coordinates; u below -1e29 is background.
    texture : (h, w, 3) uint8
    target : (H, W, 3) float32
        The normalised frame.

    Returns
    -------
    tuple of float and int
        The sum, and how many pixels were drawn.
    """
    width, height = np.float32(texture.shape[1]), np.float32(texture.shape[0])
    total, pixels = 0.0, 0
    for y in range(uv.shape[0]):
        for x in range(uv.shape[1]):
            if uv[y, x, 0] < DRAWN_FROM:
                continue
            r, g, b = _bilinear(texture, uv[y, x, 0] * width - HALF, uv[y, x, 1] * height - HALF)
            s = ONE / (r + g + b + ONE + ONE + ONE)
            dr = (r + ONE) * s - target[y, x, 0]
            dg = (g + ONE) * s - target[y, x, 1]
            db = (b + ONE) * s - target[y, x, 2]
            total += dr * dr + dg * dg + db * db
            pixels += 1
    return total, pixels


@numba.njit(cache=True, nogil=True)
def _bilinear(texture, x, y):
    """Colour at a texel position, clamped to the edge, in float32 as texture.glsl has it."""
    last_x, last_y = np.float32(texture.shape[1] - 1), np.float32(texture.shape[0] - 1)
    x, y = min(max(x, ZERO), last_x), min(max(y, ZERO), last_y)
    i, j = np.uint32(x), np.uint32(y)  # unsigned, so that numba looks for no negative index
    i2, j2 = np.uint32(min(x + ONE, last_x)), np.uint32(min(y + ONE, last_y))
    fx, fy = x - np.float32(i), y - np.float32(j)
    w00, w10, w01, w11 = (ONE - fx) * (ONE - fy), fx * (ONE - fy), (ONE - fx) * fy, fx * fy
    r = w00 * texture[j, i, 0] + w10 * texture[j, i2, 0]
    r += w01 * texture[j2, i, 0] + w11 * texture[j2, i2, 0]
    g = w00 * texture[j, i, 1] + w10 * texture[j, i2, 1]
    g += w01 * texture[j2, i, 1] + w11 * texture[j2, i2, 1]
    b = w00 * texture[j, i, 2] + w10 * texture[j, i2, 2]
    b += w01 * texture[j2, i, 2] + w11 * texture[j2, i2, 2]
    return r, g, b
