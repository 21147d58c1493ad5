"""A run's postures as weights of ARKit's 52 face units, by bounded least squares."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.export.exporter import Loss, TrackedRun, rms
from abs_engine.io.assets import Speaker


@dataclass(frozen=True, eq=False)
class UnitFit:
    """Finds the weights with which face units come nearest to a posture.

    Parameters
    ----------
    triangle : (M, U) float64
        The units, in as few rows as there can be.
    modes : (R, M) float64
        What moves the tracked head, in the same rows.
    """

    triangle: FloatArray
    modes: FloatArray

    @classmethod
    def of(cls, speaker: Speaker, modes: NDArray[np.floating[Any]]) -> UnitFit:
        """For a head with units and the modes (R, V, 3), mm, that it is tracked with.

        Raises
        ------
        ParameterError
            If the head has no face units.
        """
        if not speaker.unit_names:
            raise ParameterError("this head has no face units", "export to obj or gltf-modes")
        lists = speaker.points
        area = np.unique(np.concatenate([lists["face"], lists["lips"]]))
        units = speaker.units[:, area].astype(np.float64)
        triangle, basis = _reduced(units.reshape(len(units), -1).T)
        moved = np.asarray(modes[:, area], np.float64).reshape(len(modes), -1)
        return cls(triangle, moved @ basis)

    def weights(self, posture: FloatArray) -> FloatArray:
        """Weights (U,) between 0 and 1 of a posture (R,)."""
        found = lsq_linear(self.triangle, posture @ self.modes, (0.0, 1.0), method="bvls").x
        return np.asarray(np.clip(found, 0.0, 1.0))  # it may end a rounding error outside


@cache
def unit_weights(run: TrackedRun) -> FloatArray:
    """Weights of the face units, (T, 52), between 0 and 1; NaN in lost frames.

    They are those with which the units come nearest to the tracked face and lips; nothing is
    smoothed.

    Raises
    ------
    ParameterError
        If the head has no face units.
    """
    fit = UnitFit.of(run.speaker, run.mesh.modes)
    out = np.full((len(run), len(run.speaker.units)), np.nan)
    for frame in run.frames:
        out[frame] = fit.weights(run.mesh.weights[frame])
    return out


def _reduced(matrix: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The same least squares in as many rows as columns; the small ridge decides between ties."""
    basis, triangle = np.linalg.qr(matrix)
    ridge = 1e-3 * np.sqrt(np.mean(triangle**2))
    size = len(triangle)
    stacked = np.vstack([triangle, ridge * np.eye(size)])
    return stacked, np.hstack([basis, np.zeros((len(basis), size))])


def unit_loss(run: TrackedRun, weights: FloatArray) -> tuple[Loss, ...]:
    """Distance of faces and lips made of units from the tracked ones, mm."""
    out = []
    for area in ("lips", "face"):
        index = run.speaker.points[area]
        units = run.speaker.units[:, index].astype(np.float64)
        moved = run.mesh.points(index) - run.mesh.mean[index]
        out.append(Loss(rms(np.tensordot(weights, units, 1) - moved), "mm", area))
    return tuple(out)
