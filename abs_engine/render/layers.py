"""A texture that depends linearly on the weights, coloured pixel by pixel on the CPU.

Making the whole texture for every candidate would cost more than the pixels of one that are looked
at: these alone are put together here, as texture.glsl does on the GPU. Interpolated between texels
in all layers at once, weighed, then clipped to 0 and 255.
"""
# mypy: disable-error-code="no-untyped-def, no-untyped-call, untyped-decorator"

from __future__ import annotations

from weakref import WeakKeyDictionary

import numba
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.compiled import INNER, LOOP
from abs_engine.core.scene import ColourError, Scene

ZERO, HALF, ONE, FULL = np.float32(0), np.float32(0.5), np.float32(1), np.float32(255)
DRAWN_FROM = np.float32(-1e29)

_STACKS: WeakKeyDictionary[Scene, NDArray[np.float32]] = WeakKeyDictionary()


def colour_error(
    uv: NDArray[np.float32], scene: Scene, term: ColourError, weights: NDArray[np.float64]
) -> tuple[float, int]:
    """Sum of squared differences of luminance-normalised RGB; see `pixelsum.colour_error`."""
    total, pixels = _sum_error(uv, _stack(scene), _row(weights), term.normalised)
    return float(total), int(pixels)


def colours(
    uv: NDArray[np.float32], scene: Scene, weights: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Colours (H, W, 3), 0 to 255, of drawn pixels with texture coordinates uv (H, W, 2)."""
    out = np.zeros((*uv.shape[:2], 3), np.float32)
    _fill_colours(uv, _stack(scene), _row(weights), out)
    return out


def _stack(scene: Scene) -> NDArray[np.float32]:
    """Texture and modes of a scene, (h, w, 3, 1 + P): what a pixel reads lies together."""
    made = _STACKS.get(scene)
    if made is None:
        base = scene.texture[None].astype(np.float32)
        modes = base[:0] if scene.texture_modes is None else scene.texture_modes
        made = np.ascontiguousarray(np.concatenate([base, modes]).transpose(1, 2, 3, 0))
        _STACKS[scene] = made
    return made


def _row(weights: NDArray[np.float64]) -> NDArray[np.float32]:
    return np.concatenate([np.ones(1), weights]).astype(np.float32)


@numba.njit(**INNER)
def clamped(x, last):
    """`x` between 0 and `last`; NaN becomes `last`, so that no index leaves the texture."""
    x = x if x < last else last
    return x if x > ZERO else ZERO


@numba.njit(**INNER, error_model="numpy", fastmath={"contract", "reassoc"})
def _colour(u, v, stack, weights):
    """Colour at texture coordinates: bilinear, clamped to the edge; pixel = uv * size - 0.5."""
    height, width, _, count = stack.shape
    right, low = np.float32(width - 1), np.float32(height - 1)
    x, y = clamped(u * np.float32(width) - HALF, right), clamped(v * np.float32(height) - HALF, low)
    i, j = np.uint32(x), np.uint32(y)
    i2, j2 = np.uint32(min(x + ONE, right)), np.uint32(min(y + ONE, low))
    fx, fy = x - np.float32(i), y - np.float32(j)
    w11 = fx * fy
    w10, w01 = fx - w11, fy - w11
    w00 = ONE - fx - w01
    a, b, c, d = stack[j, i], stack[j, i2], stack[j2, i], stack[j2, i2]
    red, green, blue = ZERO, ZERO, ZERO
    for k in range(count):
        t = weights[k]
        red += t * (w00 * a[0, k] + w10 * b[0, k] + w01 * c[0, k] + w11 * d[0, k])
        green += t * (w00 * a[1, k] + w10 * b[1, k] + w01 * c[1, k] + w11 * d[1, k])
        blue += t * (w00 * a[2, k] + w10 * b[2, k] + w01 * c[2, k] + w11 * d[2, k])
    return min(max(red, ZERO), FULL), min(max(green, ZERO), FULL), min(max(blue, ZERO), FULL)


@numba.njit(**LOOP, error_model="numpy")
def _sum_error(uv, stack, weights, target):
    """Sum over drawn pixels, added up in float64 row by row, and how many there are."""
    height, width, _ = uv.shape
    total, pixels = 0.0, 0
    for y in range(height):
        row = np.float32(0)
        for x in range(width):
            if uv[y, x, 0] > DRAWN_FROM:
                r, g, b = _colour(uv[y, x, 0], uv[y, x, 1], stack, weights)
                s = ONE / (r + g + b + np.float32(3))
                dr = (r + ONE) * s - target[y, x, 0]
                dg = (g + ONE) * s - target[y, x, 1]
                db = (b + ONE) * s - target[y, x, 2]
                row += dr * dr + dg * dg + db * db
                pixels += 1
        total += np.float64(row)
    return total, pixels


@numba.njit(**LOOP, error_model="numpy")
def _fill_colours(uv, stack, weights, out):
    """Write the colour of every drawn pixel."""
    for y in range(uv.shape[0]):
        for x in range(uv.shape[1]):
            if uv[y, x, 0] > DRAWN_FROM:
                r, g, b = _colour(uv[y, x, 0], uv[y, x, 1], stack, weights)
                out[y, x, 0], out[y, x, 1], out[y, x, 2] = r, g, b
