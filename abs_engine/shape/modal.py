"""Learned physics of seed 000: the modes in which a shape was seen to move, and their stiffness.

Basu, Oliver and Pentland (1998), section 4.2. With forces that are independent and of unit
variance, R_u = K_s^-2 (eq. 3), so the sample covariance's positive square root is the learned
inverse stiffness: K_s^-1 = S L^(1/2) S' over its leading eigenvectors.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.assets import read_npz
from abs_engine.errors import ModelFormatError, ParameterError

FloatArray = NDArray[np.float64]
FORMAT, VERSION = "abs_engine.learned_physics", 1


@dataclass(frozen=True, eq=False)
class LearnedPhysics:
    """Modes of displacement with their variance.

    Parameters
    ----------
    rest : (N, 3) float64, mm
        The nodes of the shell at rest.
    mean : (N, 3) float64, mm
        Mean displacement.
    modes : (P, N, 3) float64
        Orthonormal as vectors of 3N: the columns of S.
    variances : (P,) float64, mm^2
        Eigenvalues of the sample covariance, the largest first.
    total : float, mm^2
        Variance of all degrees of freedom together.
    """

    rest: FloatArray
    mean: FloatArray
    modes: FloatArray
    variances: FloatArray
    total: float

    @property
    def held(self) -> float:
        """Share of the training variance that the modes hold, 0 to 1."""
        return float(self.variances.sum() / self.total)

    @property
    def matrix(self) -> FloatArray:
        """S (3N, P)."""
        return np.asarray(self.modes.reshape(len(self.modes), -1).T)

    def shape(self, coefficients: FloatArray) -> FloatArray:
        """Nodes (..., N, 3), mm, of mode coefficients (..., P), mm."""
        moved = np.tensordot(coefficients, self.modes, 1)
        return np.asarray(self.rest + self.mean + moved, np.float64)

    def coefficients(self, shapes: FloatArray) -> FloatArray:
        """Coefficients (..., P), mm, of the nearest shapes to nodes (..., N, 3), mm."""
        away = np.asarray(shapes, np.float64) - self.rest - self.mean
        return np.asarray(away.reshape(*away.shape[:-2], -1) @ self.matrix, np.float64)

    def pushed(self, forces: FloatArray) -> FloatArray:
        """Change of the coefficients (P,) under forces (N, 3): U = S L^(1/2) S' F (eq. 13)."""
        return np.asarray(np.sqrt(self.variances) * (self.matrix.T @ np.ravel(forces)))

    def negative_log_prior(self, coefficients: FloatArray) -> float:
        """Half of eq. 10's sum of f_i^2 / l_i; the scaling factor is left out."""
        return float(0.5 * (np.asarray(coefficients) ** 2 / self.variances).sum())

    def save(self, path: Path) -> None:
        """Write an ``.npz``."""
        np.savez_compressed(path, format=FORMAT, version=VERSION, **vars(self))


def learn(rest: FloatArray, displacements: FloatArray, n_modes: int = 10) -> LearnedPhysics:
    """Learn the physics from observed displacements.

    Parameters
    ----------
    rest : (N, 3) float64, mm
    displacements : (T, N, 3) float64, mm
        Of the training frames.
    n_modes : int

    Raises
    ------
    ParameterError
        If the frames span fewer modes, or hold what is not finite.
    """
    data = np.asarray(displacements, np.float64).reshape(len(displacements), -1)
    if not np.isfinite(data).all():
        bad = int(np.flatnonzero(~np.isfinite(data).all(axis=1))[0])
        raise ParameterError(f"displacements of frame {bad} are not finite", "leave it out")
    mean = data.mean(axis=0)
    _, scale, vectors = np.linalg.svd(data - mean, full_matrices=False)
    values = scale**2 / max(1, len(data) - 1)
    rank = int((values > 1e-12 * max(values[0], 1e-300)).sum()) if values[0] > 0 else 0
    if not 0 < n_modes <= rank:
        raise ParameterError(
            f"{n_modes} modes asked for, {len(data)} frames span {rank}", "record more motion"
        )
    modes = vectors[:n_modes]
    modes = modes * np.sign(modes[np.arange(n_modes), np.abs(modes).argmax(axis=1)])[:, None]
    shape = (-1, *np.shape(rest))
    return LearnedPhysics(
        np.asarray(rest, np.float64),
        mean.reshape(np.shape(rest)),
        modes.reshape(shape),
        values[:n_modes],
        float(values.sum()),
    )


def reconstruct(
    physics: LearnedPhysics, dofs: NDArray[np.integer], observed: FloatArray, noise: float
) -> FloatArray:
    """Most probable coefficients given some coordinates of some nodes (section 6.2).

    Parameters
    ----------
    physics : LearnedPhysics
    dofs : (n,) int
        Observed degrees of freedom: 3 times the node, plus 0, 1, 2 for x, y, z.
    observed : (..., n) float64, mm
        Coordinates, not displacements.
    noise : float, mm
        Standard deviation of a coordinate's error, positive.

    Returns
    -------
    (..., P) float64, mm

    Raises
    ------
    ParameterError
        If nothing is observed or the noise is not positive.

    Notes
    -----
    With Gaussian noise and the prior of eq. 10 this is ridge regression:
    (A' A / s^2 + L^-1) c = A' d / s^2, with A the observed rows of S.
    """
    if len(dofs) == 0 or not noise > 0:
        raise ParameterError("nothing observed, or noise not positive", "give both")
    a = physics.matrix[dofs]
    away = np.asarray(observed, np.float64) - np.ravel(physics.rest + physics.mean)[dofs]
    normal = a.T @ a / noise**2 + np.diag(1 / physics.variances)
    return np.asarray(np.linalg.solve(normal, a.T @ np.moveaxis(away, -1, 0) / noise**2).T)


def load_physics(path: Path) -> LearnedPhysics:
    """Read what `LearnedPhysics.save` wrote.

    Raises
    ------
    InputFileError
        If it is missing or cannot be read.
    ModelFormatError
        If it has another format or version, or lacks an array.
    """
    arrays = read_npz(Path(path), FORMAT, VERSION)
    try:
        rest, mean, modes, variances = (
            np.asarray(arrays[name], np.float64) for name in ("rest", "mean", "modes", "variances")
        )
        return LearnedPhysics(rest, mean, modes, variances, float(arrays["total"]))
    except KeyError as error:
        raise ModelFormatError(f"{path} lacks {error}", "train it again") from error
