"""A drawing put into the light of a picture: what a texture lacks is a function of the normal.

Under distant lamps, what a matt surface throws back varies smoothly with its normal, and nine
spherical harmonics hold nearly all of it (Ramamoorthi and Hanrahan 2001). It multiplies the
texture. The gloss of skin is added to it, white on dark skin, too; seen from one side it is a
function of the normal as well, though a steeper one.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
_ROUNDS = 3
_MOST = 6000  # pixels that the light is found from
_WEAK = np.r_[np.full(9, 1e-4), np.full(16, 1e-3)]  # ridge, by which undetermined terms stay small


def relit(
    drawn: NDArray[np.floating],
    seen: NDArray[np.floating],
    normals: FloatArray,
    compared: NDArray[np.bool_],
) -> FloatArray:
    """Drawn pixels as the light of a picture would show them.

    Parameters
    ----------
    drawn : (N, 3), 0 to 255
        Colours of the texture.
    seen : (N, 3), 0 to 255
        The picture at the same pixels.
    normals : (N, 3) float64
        Unit normals at them, in axes that keep still while the light does.
    compared : (N,) bool
        Pixels that the light is found from. What is not as drawn there, such as a shut eye or a
        bright spot, counts little.

    Returns
    -------
    (N, 3) float64, 0 to 255
        ``drawn`` without `compared` pixels.
    """
    chosen = np.flatnonzero(compared)
    chosen = chosen[:: 1 + len(chosen) // _MOST]
    if len(chosen) < len(_WEAK):
        return np.asarray(drawn, np.float64)
    matt, gloss = _harmonics(normals), _steeper(normals)
    out = np.empty(np.shape(drawn), np.float64)
    for channel in range(3):
        colour = drawn[:, channel, None] / 255
        terms = np.hstack([colour * matt, gloss])
        out[:, channel] = terms @ _robust(terms[chosen], seen[chosen, channel].astype(np.float64))
    return out


def _harmonics(normals: FloatArray) -> FloatArray:
    """Real spherical harmonics up to the second order, without their factors, (N, 9)."""
    x, y, z = normals.T
    terms = [np.ones_like(x), x, y, z, x * y, x * z, y * z, x * x - y * y, 3 * z * z - 1]
    return np.stack(terms, axis=1)


def _steeper(normals: FloatArray) -> FloatArray:
    """Those up to the third order, (N, 16)."""
    x, y, z = normals.T
    third = [
        y * (3 * x * x - y * y), x * y * z, y * (5 * z * z - 1), z * (5 * z * z - 3),
        x * (5 * z * z - 1), z * (x * x - y * y), x * (x * x - 3 * y * y),
    ]  # fmt: skip
    return np.hstack([_harmonics(normals), np.stack(third, axis=1)])


def _robust(terms: FloatArray, values: FloatArray) -> FloatArray:
    """Least squares in which outliers count less (Geman-McClure's weights)."""
    weights = np.ones(len(values))
    ridge = np.diag(len(values) * _WEAK)
    for _ in range(_ROUNDS):
        weighted = terms * weights[:, None]
        found = np.linalg.solve(weighted.T @ terms + ridge, weighted.T @ values)
        away = values - terms @ found
        usual = 3 * np.median(np.abs(away)) + 0.5
        weights = 1 / (1 + (away / usual) ** 2)
    return np.asarray(found)


def gray(picture: NDArray[np.floating]) -> NDArray[np.float32]:
    """Luminance (H, W) float32 of (H, W, 3), a little smoothed against noise."""
    flat = cv2.cvtColor(np.asarray(picture, np.float32), cv2.COLOR_RGB2GRAY)
    return np.asarray(cv2.GaussianBlur(flat, (0, 0), 1.0), np.float32)
