"""The radial part of OpenCV's lens model, and how far it can be used."""

from __future__ import annotations

import numpy as np

from abs_engine.core.arrays import FloatArray

_SAMPLES = 4000
"""Radii that are looked at, each 0.2 % larger than the one before for common lenses."""


def radial_factor(distortion: FloatArray, r2: FloatArray) -> FloatArray:
    """The factor by which a lens moves points away from its axis, or towards it.

    Of squared radii, normalised units; the distortion (8,) is as in `Camera`.
    """
    k1, k2, _, _, k3, k4, k5, k6 = distortion
    over = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    under = 1 + r2 * (k4 + r2 * (k5 + r2 * k6))
    return np.asarray(over / under)


def unfolded(distortion: FloatArray, most: float) -> float:
    """The largest r^2, normalised units, `most` or less, up to which the distorted radius grows.

    The distortion (8,) is as in `Camera`.
    """
    if not 0 < most < np.inf:
        return most
    r2 = np.geomspace(1e-6 * min(most, 1.0), most, _SAMPLES)
    with np.errstate(all="ignore"):  # coefficients that no lens has
        radius = np.sqrt(r2) * radial_factor(distortion, r2)
        falls = np.flatnonzero(np.diff(radius) <= 0)
    return float(r2[falls[0]]) if len(falls) else most
