"""Spherical harmonics: how the light on a matt surface varies with its normal."""

from __future__ import annotations

import numpy as np

from abs_engine.core.arrays import FloatArray

HARMONICS = 9


def harmonics(normals: FloatArray) -> FloatArray:
    """Real spherical harmonics (..., 9), without their factors, of unit vectors (..., 3).

    Up to the second order. Under distant lamps they hold nearly all of the light that a matt
    surface receives (Ramamoorthi and Hanrahan, "An efficient representation for irradiance
    environment maps", 2001).
    """
    x, y, z = np.moveaxis(normals, -1, 0)
    terms = [np.ones_like(x), x, y, z, x * y, x * z, y * z, x * x - y * y, 3 * z * z - 1]
    return np.stack(terms, axis=-1)
