"""Learned physics: the modes in which a shape was seen to move, and their stiffness.

Basu, Oliver and Pentland (1998), section 4.2. With forces that are independent and of unit
variance, R_u = K_s^-2 (eq. 3), so the sample covariance's positive square root is the learned
inverse stiffness: K_s^-1 = S L^(1/2) S' over its leading eigenvectors.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.face.settings.shape import SHAPE
from abs_engine.io.arrays import Layout, plain, real, text
from abs_engine.io.npz import read_npz, write_npz

FORMAT, VERSION = "abs_engine.learned_physics", 2
_STILL = 1e-12  # mm^2: variance of a mode that is rounding, not motion


_LAYOUT: Layout = {
    "rest": real("N", 3),
    "mean": real("N", 3),
    "modes": real("P", "N", 3),
    "variances": real("P", low=0.0),
    "total": real(low=0.0),
    "noise": real(low=0.0),
    **dict.fromkeys(("person", "speaker", "source"), text()),
    "noise_variances": real("P?", low=0.0),
    "motion_variances": real("P?", low=0.0, optional=True),
}


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
    noise : float, mm
        Standard deviation by which an observed coordinate is off the modes: errors of observation,
        and motion that the modes do not have. 0 where it is not known.
    person : str
        Whose lips they are, of the speaker's people; empty for somebody else.
    speaker : str
        Checksum of the head that the shell was cut from; empty where it is of none.
    source : str
        What was learned from.
    noise_variances : (P,) float64, mm^2
        How much of `variances` errors of observation make; none where they are not known.
    motion_variances : (P,) float64, mm^2
        What `variances` are in motion that was not learned from, see `learn.held_out`; none where
        that is not known.
    """

    rest: FloatArray
    mean: FloatArray
    modes: FloatArray
    variances: FloatArray
    total: float
    noise: float = 0.0
    person: str = ""
    speaker: str = ""
    source: str = ""
    noise_variances: FloatArray = field(default_factory=lambda: np.zeros(0))
    motion_variances: FloatArray = field(default_factory=lambda: np.zeros(0))

    @property
    def expected(self) -> FloatArray:
        """Variances (P,), mm^2, of other motion, with errors of observation as `variances`."""
        return self.motion_variances if len(self.motion_variances) else self.variances

    @property
    def deviations(self) -> FloatArray:
        """Standard deviations (P,), mm, of other motion itself, without errors of observation.

        A weak mode that is mostly error would else be free to move by as much; a share of its
        variance is left to it.
        """
        noise = self.noise_variances if len(self.noise_variances) else 0.0
        return np.asarray(
            np.sqrt(np.maximum(self.expected - noise, SHAPE.left_motion * self.expected))
        )

    @property
    def held(self) -> float:
        """Share of the training variance that the modes hold, 0 to 1."""
        return float(self.variances.sum() / self.total)

    @property
    def shares(self) -> FloatArray:
        """Share (P,) of the training variance that the first mode, the first two, ... hold."""
        return np.asarray(np.cumsum(self.variances) / self.total)

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

    def save(self, path: Path) -> None:
        """Write an ``.npz``, whole or not at all; `OutputError` if it cannot be."""
        write_npz(path, FORMAT, VERSION, vars(self))


def learn(
    rest: FloatArray,
    displacements: FloatArray,
    n_modes: int = 10,
    *,
    weights: FloatArray | None = None,
    spread: FloatArray | None = None,
) -> LearnedPhysics:
    """Learn the physics from observed displacements.

    Parameters
    ----------
    rest : (N, 3) float64, mm
    displacements : (T, N, 3) float64, mm
        Of the training frames.
    n_modes : int
    weights : (T,) float64, optional
        How much each frame counts, above 0; by default all the same. The covariance is unbiased for
        independent frames of any weights.
    spread : (R, N, 3) float64, mm, optional
        What is added to the covariance of the displacements: the sum of the outer products of
        these. Displacements that are means of a posterior have less covariance than the motion, by
        as much as the posterior has on average.

    Raises
    ------
    ParameterError
        If there are none, they span fewer modes, or hold what is not finite.
    """
    data = _rows_of(displacements, rest)
    share = np.ones(len(data)) if weights is None else np.asarray(weights, np.float64)
    share = share / share.sum()
    mean = share @ data
    freedom = max(1.0 - float(share @ share), float(np.finfo(np.float64).eps))  # 1 - 1/T if equal
    rows = np.sqrt(share / freedom)[:, None] * (data - mean)
    if spread is not None:
        rows = np.concatenate([rows, np.reshape(spread, (-1, data.shape[1]))])
    _, scale, vectors = np.linalg.svd(rows, full_matrices=False)
    values = scale**2
    rank = int((values > max(1e-12 * values[0], _STILL)).sum())
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


def _rows_of(displacements: FloatArray, rest: FloatArray) -> FloatArray:
    """Displacements (T, 3N) of frames; a `ParameterError` where there are none such."""
    if (
        np.ndim(displacements) != 3
        or np.shape(displacements)[1:] != np.shape(rest)
        or (len(displacements) == 0)
    ):
        raise ParameterError(
            f"displacements of shape {np.shape(displacements)} are not frames of a shell with "
            f"{len(rest)} nodes",
            "give (T, N, 3) of one frame or more",
        )
    data = np.asarray(displacements, np.float64).reshape(len(displacements), -1)
    if not np.isfinite(data).all():
        bad = int(np.flatnonzero(~np.isfinite(data).all(axis=1))[0])
        raise ParameterError(f"displacements of frame {bad} are not finite", "leave it out")
    return data


def load_physics(path: Path) -> LearnedPhysics:
    """Read what `LearnedPhysics.save` wrote.

    Raises `InputFileError` if it is missing or cannot be read, `ModelFormatError` if it has another
    format or version, or lacks an array.
    """
    return LearnedPhysics(**plain(read_npz(Path(path), FORMAT, VERSION, _LAYOUT, "train it again")))
