"""A smooth field over a head of what points measure beside it, as smooth as they are noisy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import RBFInterpolator

from abs_engine.core.arrays import FloatArray
from abs_engine.learn.measured.settings import MEASURED_FACE


@dataclass(frozen=True)
class Smoothness:
    """Smoothness of a field.

    Parameters
    ----------
    reach : float, mm
    noise : float
        See `MEASURED_FACE.reaches` and `noises`; an infinite one leaves no field.
    explained : float
        Share of the values at points that were left out which the others' field explains.
    """

    reach: float
    noise: float
    explained: float


def smoothness(places: FloatArray, values: FloatArray) -> Smoothness:
    """The smoothness with which points predict others best: cross-validation in tenths.

    Parameters
    ----------
    places : (N, 3) float64, mm
    values : (N, K) float64
    """
    fold = np.arange(len(places)) % min(MEASURED_FACE.folds, len(places))
    whole = max(float((values**2).sum()), 1e-300)
    best = Smoothness(MEASURED_FACE.reaches[0], np.inf, 0.0)  # nothing at all explains nothing
    for reach in MEASURED_FACE.reaches:
        for noise in MEASURED_FACE.noises:
            lost = 0.0
            for kept in (fold != k for k in range(fold.max() + 1)):
                said = field(places[kept], values[kept], reach, noise, places[~kept])
                lost += float(((said - values[~kept]) ** 2).sum())
            if 1 - lost / whole > best.explained:
                best = Smoothness(reach, noise, 1 - lost / whole)
    return best


def field(
    places: FloatArray, values: FloatArray, reach: float, noise: float, wanted: FloatArray
) -> FloatArray:
    """Values (M, K) at wanted places (M, 3), mm, of values (N, K) at places (N, 3).

    Far from all places they are 0.
    """
    if not np.isfinite(noise):
        return np.zeros((len(wanted), values.shape[1]))
    made = RBFInterpolator(
        places, values, kernel="gaussian", epsilon=1 / (np.sqrt(2) * reach), degree=-1,
        smoothing=noise,
    )  # fmt: skip
    return np.asarray(made(wanted), np.float64)
