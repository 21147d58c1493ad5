"""A run's postures as weights of ARKit's 52 face units, by bounded least squares."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.export.exporter import Loss, TrackedRun
from abs_engine.export.reading import compared
from abs_engine.export.settings import EXPORT
from abs_engine.face.neutral import Moving, neutral_face
from abs_engine.io.assets import Speaker


@dataclass(frozen=True, eq=False)
class UnitFit:
    """Finds the weights with which face units, on the neutral face, come nearest to a posture.

    Parameters
    ----------
    triangle : (M, U) float64
        The units, in as few rows as there can be.
    modes : (P, M) float64
        What moves the tracked head, in the same rows.
    mean : (M,) float64
        How posture 0 differs from the person's neutral face, in the same rows.
    """

    triangle: FloatArray
    modes: FloatArray
    mean: FloatArray

    @classmethod
    def of(cls, speaker: Speaker, head: Moving, weight_cost: float = EXPORT.weight_cost) -> UnitFit:
        """For a tracked head.

        Parameters
        ----------
        weight_cost : float
            mm; see `ExportSettings`.

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
        # the same least squares in as many rows as units, and a row for each unit's cost
        basis, triangle = np.linalg.qr(units.reshape(len(units), -1).T)
        cost, size = float(weight_cost * np.sqrt(len(area))), len(triangle)
        triangle = np.vstack([triangle, cost * np.eye(size)])
        basis = np.hstack([basis, np.zeros((len(basis), size))])
        modes = np.asarray(head.modes[:, area], np.float64).reshape(len(head.modes), -1)
        mean = (head.mean - neutral_face(head, lists["landmark_68"]))[area].ravel()
        return cls(triangle, modes @ basis, mean @ basis)

    def weights(self, posture: FloatArray) -> FloatArray:
        """Weights (U,) between 0 and 1 of a posture (P,)."""
        moved = self.mean + posture @ self.modes
        found = lsq_linear(self.triangle, moved, (0.0, 1.0), method="bvls").x
        return np.asarray(np.clip(found, 0.0, 1.0))  # it may end a rounding error outside


def unit_weights(run: TrackedRun) -> FloatArray:
    """Weights of the face units, (T, 52), between 0 and 1; NaN in lost frames.

    They are those with which the units, on the person's neutral face, come nearest to the tracked
    face and lips, at a small cost of each weight (`EXPORT.weight_cost`); nothing is smoothed.

    Raises
    ------
    ParameterError
        If the head has no face units.
    """
    fit = UnitFit.of(run.speaker, run.mesh)
    return run.in_all(np.array([fit.weights(run.mesh.weights[frame]) for frame in run.frames]))


def unit_loss(run: TrackedRun, weights: FloatArray) -> tuple[Loss, ...]:
    """Distance of neutral faces and lips moved by units from the tracked ones, mm."""
    units = run.speaker.units.astype(np.float64)
    return shape_loss(run, run.neutral, units, weights, weights_of(run.speaker))


def weights_of(speaker: Speaker) -> str:
    """Words for the weights of a head's face units."""
    return f"ARKit's {len(speaker.unit_names)} weights"


def shape_loss(
    run: TrackedRun, base: FloatArray, targets: FloatArray, weights: FloatArray, by: str = ""
) -> tuple[Loss, ...]:
    """Distance of lips and face, a base (V, 3) moved by weighted targets, from the tracked, mm."""
    out = []
    for area in ("lips", "face"):
        index = run.speaker.points[area]
        moved = base[index] + np.tensordot(weights, targets[:, index], 1)
        out.append(compared(moved, run.points(index), "mm", area, by=by))
    return tuple(out)
