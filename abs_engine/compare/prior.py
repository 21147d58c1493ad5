"""Priors over parameters (Basu et al., eq. 10)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class GaussianPrior:
    """-log of a Gaussian with a diagonal covariance, without its constant.

    Eq. 10 prints sum f_i^2 / lambda_i; the 1/2 of a Gaussian's exponent is put back.

    Parameters
    ----------
    mean : (N,) float64
    deviation : (N,) float64
        Standard deviations; infinite where nothing is known.
    """

    mean: NDArray[np.float64]
    deviation: NDArray[np.float64]

    def negative_log(self, x: NDArray[np.float64]) -> float:
        """0.5 sum ((x - mean) / deviation)^2."""
        scaled = (x - self.mean) / self.deviation
        return float(0.5 * scaled @ scaled)


@dataclass(frozen=True, eq=False)
class ContactPrior:
    """Lips may press, but hardly pass into each other.

    Parameters
    ----------
    gap : (G,) float64, mm
        Gaps between upper and lower lip with all parameters zero.
    slope : (G, N) float64, mm per unit of parameter
    softness : float
        Depth in mm that is as improbable as one standard deviation.
    """

    gap: NDArray[np.float64]
    slope: NDArray[np.float64]
    softness: float = 0.6

    def negative_log(self, x: NDArray[np.float64]) -> float:
        """0.5 sum (depth / softness)^2 over the gaps that are negative."""
        depth = np.minimum(self.gap + self.slope @ x, 0.0) / self.softness
        return float(0.5 * depth @ depth)
