"""A run's postures as weights of ARKit's 52 face units, by bounded least squares."""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.optimize import lsq_linear

from abs_engine.core.errors import ParameterError
from abs_engine.export.exporter import FloatArray, Loss, TrackedRun, rms


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
    if not run.speaker.unit_names:
        raise ParameterError("this head has no face units", "export to obj or gltf-modes")
    units, area = run.speaker.units, _area(run)
    triangle, basis = _reduced(units[:, area].astype(np.float64).reshape(len(units), -1).T)
    moved = np.asarray(run.mesh.modes[:, area], np.float64).reshape(len(run.mesh.modes), -1)
    wanted = run.mesh.weights @ moved @ basis
    out = np.full((len(run), len(units)), np.nan)
    for frame in run.frames:
        found = lsq_linear(triangle, wanted[frame], (0.0, 1.0), method="bvls").x
        out[frame] = np.clip(found, 0.0, 1.0)  # it may end a rounding error outside
    return out


def _area(run: TrackedRun) -> np.ndarray:
    lists = run.speaker.points
    return np.unique(np.concatenate([lists["face"], lists["lips"]]))


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
