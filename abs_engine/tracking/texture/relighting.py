"""A drawing put into the light of a picture: what a texture lacks is a function of the normal.

Under distant lamps, what a matt surface throws back varies smoothly with its normal (see
`face.appearance.harmonics`). It multiplies the texture. The gloss of skin is added to it, bright on
dark skin, too; seen from one side it is a function of the normal as well, though a steeper one: a
sum of lobes.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.face.appearance.harmonics import harmonics
from abs_engine.tracking.settings.registration import REGISTRATION

Gray = NDArray[np.float32]


def gray(picture: NDArray[np.generic]) -> Gray:
    """Luminance (H, W) float32 of RGB (H, W, 3)."""
    return np.asarray(cv2.cvtColor(np.asarray(picture, np.float32), cv2.COLOR_RGB2GRAY))


def smooth(picture: Gray) -> Gray:
    """A picture with a little less noise, see `REGISTRATION.smoothing`."""
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), REGISTRATION.smoothing), np.float32)


def relit(
    drawn: NDArray[np.floating],
    seen: NDArray[np.floating],
    normals: FloatArray,
    compared: BoolArray,
) -> FloatArray:
    """Drawn pixels (N,), 0 to 255, as the light of a picture would show them.

    The luminance of the texture is `drawn`, that of the picture there `seen`; `normals` (N, 3) are
    of unit length, camera frame. The light is found from the pixels that are `compared` (N,). What
    is not as drawn there, such as a shut eye, counts little. Where too few are, ``drawn`` itself is
    returned.
    """
    chosen = np.flatnonzero(compared)
    chosen = chosen[:: 1 + len(chosen) // REGISTRATION.light_pixels]
    matt = np.asarray(drawn, np.float64)[:, None] / 255 * harmonics(normals)
    gloss = _lobes(normals)
    terms = np.hstack([matt, np.ones((len(matt), 1)), gloss])
    if len(chosen) < terms.shape[1]:
        return np.asarray(drawn, np.float64)
    weak = np.r_[
        np.full(matt.shape[1], REGISTRATION.light_ridge[0]),
        np.full(1 + gloss.shape[1], REGISTRATION.light_ridge[1]),
    ]
    light = _robust(terms[chosen], np.asarray(seen, np.float64)[chosen], weak)
    return np.clip(terms @ light, 0, 255)


def _lobes(normals: FloatArray) -> FloatArray:
    """Nearness of each normal (N, 3) to directions spread over what faces the camera, (N, L)."""
    k = (
        np.arange(2 * REGISTRATION.lobes) + 0.5
    )  # a spiral of golden angles (Vogel 1979) round the sphere
    away, turn = k / REGISTRATION.lobes - 1, np.pi * (1 + np.sqrt(5)) * k
    radius = np.sqrt(1 - away**2)
    centres = np.stack([radius * np.cos(turn), radius * np.sin(turn), away], axis=1)
    facing = centres[away < REGISTRATION.lobes_turned]  # z points away from the camera
    near = normals @ facing.T
    near -= 1  # in place, here and below: so many numbers take longer to move than to compute
    np.minimum(near, 0.0, out=near)
    near /= np.radians(REGISTRATION.lobe_width) ** 2
    lobes = near.astype(np.float32)
    np.exp(lobes, out=lobes)
    return np.asarray(lobes, np.float64)


def _robust(terms: FloatArray, values: FloatArray, weak: FloatArray) -> FloatArray:
    """Ridge regression in which outliers count less (Cauchy weights)."""
    weights = np.ones(len(values))
    ridge = np.diag(len(values) * weak)
    for _ in range(REGISTRATION.light_rounds):
        weighted = terms * weights[:, None]
        found = np.linalg.solve(weighted.T @ terms + ridge, weighted.T @ values)
        away = values - terms @ found
        usual = REGISTRATION.light_outlier * np.median(np.abs(away)) + REGISTRATION.light_noise
        weights = 1 / (1 + (away / usual) ** 2)
    return np.asarray(found)
