"""The pixel terms of `core.scene.py`, summed over what was drawn, in loops compiled by numba.

On a software rasteriser a fragment shader runs on whole 4x4 blocks for every small triangle that
touches them, about ten lanes for each pixel kept. So there the shader only writes a class or
texture coordinates, and the term is computed once for each pixel, here. The CPU rasteriser does
the same. The colour loop is written so that LLVM turns it into vector code: no branch, no 64-bit
or signed index, one array for each channel.
"""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

from weakref import WeakKeyDictionary

import numba
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.compiled import INNER, LOOP
from abs_engine.core.scene import ColourError, Scene
from abs_engine.render import layers
from abs_engine.render.layers import DRAWN_FROM, HALF, ONE, ZERO, clamped

_CELLS: WeakKeyDictionary[Scene, NDArray[np.int32]] = WeakKeyDictionary()
_PLANES: WeakKeyDictionary[ColourError, NDArray[np.float32]] = WeakKeyDictionary()


def colour_error(
    uv: NDArray[np.float32], scene: Scene, term: ColourError, weights: NDArray[np.float64]
) -> tuple[float, int]:
    """Sum of squared differences of luminance-normalised RGB, and how many pixels were drawn.

    Parameters
    ----------
    uv : (H, W, 2) float32
        Texture coordinates of each pixel; u below -1e29 is background.
    scene : Scene
        Whose texture is drawn.
    weights : (P,) float64
        Of the scene's modes; read where its texture depends on them.
    """
    if scene.texture_modes is not None:
        return layers.colour_error(uv, scene, term, weights)
    cells, target = _CELLS.get(scene), _PLANES.get(term)
    if cells is None:
        cells = _CELLS[scene] = texel_cells(scene.texture)
    if target is None:
        target = _PLANES[term] = np.ascontiguousarray(term.normalised.transpose(2, 0, 1))
    total, pixels = sum_colour_error(uv, cells, target)
    return float(total), int(pixels)


def texel_cells(texture: NDArray[np.uint8]) -> NDArray[np.int32]:
    """Cells (3, h, w) int32 of a texture: each texel with its right, lower and lower right one.

    For each channel the four values that bilinear interpolation needs, eight bits each, so that
    they come with one load; the edge is repeated.
    """
    padded = np.pad(texture, ((0, 1), (0, 1), (0, 0)), mode="edge").astype(np.uint32)
    upper = padded[:-1, :-1] | padded[:-1, 1:] << 8
    lower = padded[1:, :-1] | padded[1:, 1:] << 8
    return np.ascontiguousarray((upper | lower << 16).transpose(2, 0, 1)).view(np.int32)


@numba.njit(**LOOP)
def sum_class_maps(classes, maps):
    """Sum of maps (C, H, W) over the pixels of drawn classes (H, W), not 0, and how many."""
    total, pixels = 0.0, 0
    for y in range(classes.shape[0]):
        for x in range(classes.shape[1]):
            c = classes[y, x]
            if c > 0:
                total += maps[c, y, x]
                pixels += 1
    return total, pixels


@numba.njit(**LOOP)
def sum_colour_error(uv, cells, target):
    """Sum of squared differences of luminance-normalised RGB, and how many pixels were drawn.

    It is added up in float64 row by row. `uv` (H, W, 2) is as in `colour_error`, `cells` (3, h, w)
    as in `texel_cells`; `target` (3, H, W) is the normalised frame.
    """
    height, width, _ = uv.shape
    _, texture_height, texture_width = cells.shape
    flat = uv.reshape(-1)  # one dimension: LLVM then knows the strides
    reds, greens, blues = cells[0].reshape(-1), cells[1].reshape(-1), cells[2].reshape(-1)
    red, green, blue = target[0].reshape(-1), target[1].reshape(-1), target[2].reshape(-1)
    total, pixels = 0.0, 0
    for y in range(height):
        row, drawn = _colour_row(
            flat, reds, greens, blues, texture_width, texture_height,
            red, green, blue, np.uint64(y * width), np.uint64((y + 1) * width),
        )  # fmt: skip
        total += row
        pixels += drawn
    return total, pixels


@numba.njit(**INNER, error_model="numpy", fastmath={"contract", "reassoc", "arcp"})
def _colour_row(uv, reds, greens, blues, width, height, red, green, blue, start, stop):
    """`sum_colour_error` of pixels `start` to `stop`, in float32 as texture.glsl has it."""
    columns, rows = np.float32(width), np.float32(height)
    stride = np.int32(width)
    total, pixels = ZERO, np.int32(0)
    for n in range(start, stop):
        u, v = uv[np.uint64(2) * n], uv[np.uint64(2) * n + np.uint64(1)]
        drawn = u > DRAWN_FROM
        x, y = clamped(u * columns - HALF, columns - ONE), clamped(v * rows - HALF, rows - ONE)
        i, j = np.int32(x), np.int32(y)
        fx, fy = x - np.float32(i), y - np.float32(j)
        at = np.uint32(np.int32(j * stride + i))
        r = _bilinear(reds[at], fx, fy) + ONE
        g = _bilinear(greens[at], fx, fy) + ONE
        b = _bilinear(blues[at], fx, fy) + ONE
        s = ONE / (r + g + b)
        dr, dg, db = r * s - red[n], g * s - green[n], b * s - blue[n]
        error = dr * dr + dg * dg + db * db
        total += error if drawn else ZERO
        pixels += np.int32(1) if drawn else np.int32(0)
    return total, pixels


@numba.njit(**INNER, fastmath={"contract", "reassoc"})
def _bilinear(cell, fx, fy):
    """Interpolate between the four bytes of a cell."""
    w11 = fx * fy
    w10, w01 = fx - w11, fy - w11
    value = (ONE - fx - w01) * np.float32(np.int32(cell & 255))
    value += w10 * np.float32(np.int32((cell >> 8) & 255))
    value += w01 * np.float32(np.int32((cell >> 16) & 255))
    return value + w11 * np.float32(np.int32((cell >> 24) & 255))
