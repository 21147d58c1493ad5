"""The whole shape from any part of it, and how sure it is (Basu et al. 1998, section 6.2).

With a Gaussian prior over the modes (eq. 10) and Gaussian errors, the shape given any coordinates
of any points is Gaussian as well.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.face.shape.modal import LearnedPhysics

Rows: TypeAlias = NDArray[np.integer] | Any  # scipy's sparse matrices have no types
"""Degrees of freedom (n,), 3 times the node plus 0, 1, 2 for x, y, z; or the weights (n, 3N) of all
of them in n coordinates, as `dots.ShellPoints.rows` gives them."""
_LEAST_NOISE = 1e-6  # mm


@dataclass(frozen=True, eq=False)
class Posterior:
    """Shapes given what was observed of them.

    `coefficients` (..., P), mm, are the most probable ones. Their covariance (P, P), mm^2, does not
    depend on what was seen, only on what is seen.
    """

    physics: LearnedPhysics
    coefficients: FloatArray
    covariance: FloatArray

    @property
    def shapes(self) -> FloatArray:
        """Nodes (..., N, 3), mm, of the most probable shapes."""
        return self.physics.shape(self.coefficients)

    @property
    def deviation(self) -> float:
        """Root mean square, mm, that a node is expected to be off: of the covariance's trace."""
        return float(np.sqrt(np.trace(self.covariance) / len(self.physics.rest)))


def reconstruct(
    physics: LearnedPhysics, rows: Rows, observed: FloatArray, noise: float | None = None
) -> Posterior:
    """Shapes, given some coordinates of some points.

    Parameters
    ----------
    physics : LearnedPhysics
    rows : (n,) int, or (n, 3N) sparse
        What is observed, see `Rows`.
    observed : (..., n) float64, mm
        Coordinates, not displacements.
    noise : float, mm, optional
        Standard deviation of a coordinate's error, 1e-6 or more; by default that of the physics.

    Raises
    ------
    ParameterError
        If nothing is observed, it does not fit, is not finite or of no degree of freedom, or the
        noise is below 1e-6 mm or not finite.

    Notes
    -----
    The mean is ridge regression: (A' A / s^2 + L^-1) c = A' d / s^2, with A the observed rows of S
    and L the modes' variances; the covariance is the inverse of the same matrix.
    """
    seen, covariance, variance = _posterior(physics, rows, noise)
    observed = np.asarray(observed, np.float64)
    if observed.shape[-1] != len(seen):
        raise ParameterError(
            f"{observed.shape[-1]} values for {len(seen)} coordinates", "give one for each"
        )
    if not np.isfinite(observed).all():
        raise ParameterError("an observed value is not finite", "leave its coordinate out")
    away = observed - _picked(rows, np.ravel(physics.rest + physics.mean)[:, None])[:, 0]
    return Posterior(physics, away @ (seen @ covariance) / variance, covariance)


def expected_posterior(
    physics: LearnedPhysics, rows: Rows, noise: float | None = None
) -> Posterior:
    """Posterior of the shape once some coordinates are observed; coefficients are 0.

    Raises `ParameterError` as `reconstruct`.
    """
    covariance = _posterior(physics, rows, noise)[1]
    return Posterior(physics, np.zeros(len(covariance)), covariance)


def _posterior(
    physics: LearnedPhysics, rows: Rows, noise: float | None
) -> tuple[FloatArray, FloatArray, float]:
    """A (n, P), the coefficients' covariance (P, P), and the noise's variance."""
    noise = physics.noise if noise is None else noise
    seen = _picked(rows, physics.matrix)
    if len(seen) == 0 or not 0 < noise < np.inf:
        raise ParameterError(
            "nothing is observed, or the noise is not positive, or not finite",
            "observe a coordinate or more, with a finite noise above 0 mm",
        )
    if noise < _LEAST_NOISE:
        raise ParameterError(
            f"a noise of {noise:g} mm is below the rounding of coordinates",
            f"give {_LEAST_NOISE:g} mm or more",
        )
    root = np.sqrt(physics.variances)
    scaled = seen * root / noise  # in standard deviations, so that small modes are not lost
    inner = np.linalg.inv(np.eye(len(root)) + scaled.T @ scaled)
    return seen, root[:, None] * inner * root, noise**2


def _picked(rows: Rows, columns: FloatArray) -> FloatArray:
    """Rows of a matrix (3N, P), or weighted sums of them, (n, P)."""
    size = len(columns)
    if sparse.issparse(rows):
        if rows.shape[1] != size:
            raise ParameterError(
                f"weights for {rows.shape[1]} degrees of freedom do not fit {size}",
                "make them for this shell",
            )
        return np.asarray(rows @ columns, np.float64)
    at = np.asarray(rows, np.int64)
    wrong = at[(at < 0) | (at >= size)]
    if wrong.size:
        raise ParameterError(
            f"the physics has no degree of freedom {wrong[0]}", f"give 0 to {size - 1}"
        )
    return np.asarray(columns[at], np.float64)
