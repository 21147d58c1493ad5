"""Guided principal components: each explains, one after the other, what is left.

Odisio and Bailly (2003), section 2.2: each is the first principal component of selected coordinates
of the residual; the residual of all points is regressed on it, and the explained part is taken
away.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.core.errors import ParameterError
from abs_engine.face.shape.predictors import Predictor

_NOTHING = 1e-12
"""Share of the variance below which a predictor's residual counts as none."""
_ROUNDS, _SETTLED = 200, 1e-4  # of imputing; mm


@dataclass(frozen=True, eq=False)
class Components:
    """Results of the steps of the analysis: flat arrays, D coordinates."""

    mean: FloatArray
    modes: FloatArray
    scores: FloatArray
    variance: FloatArray


def guided(
    data: FloatArray, predictors: Sequence[Predictor], columns: Sequence[IntArray]
) -> Components:
    """The analysis of complete data (V, D)."""
    mean = data.mean(axis=0)
    residual = data - mean
    total = float((residual**2).sum())
    modes, scores, shares = [], [], []
    for predictor, own in zip(predictors, columns, strict=True):
        left, square, right = _first(residual[:, own])
        if not square > _NOTHING * total:
            raise ParameterError(
                f"predictor '{predictor.name}' finds nothing left to explain",
                "leave it out, or give it other points",
            )
        score = left * np.sqrt(len(data) - 1) * predictor.orientation(right, own)
        mode = score @ residual / (score @ score)
        residual = residual - np.outer(score, mode)
        modes.append(mode)
        scores.append(score)
        shares.append((score @ score) * (mode @ mode) / total)
    return Components(mean, np.array(modes), np.stack(scores, axis=1), np.array(shares))


def _first(rows: FloatArray) -> tuple[FloatArray, float, FloatArray]:
    """First left singular vector (V,) of rows (V, K), its value squared, and the right one (K,).

    By the smaller Gram matrix: singular values of what filled gaps leave may not converge.
    """
    wide = rows.shape[1] > len(rows)
    values, vectors = np.linalg.eigh(rows @ rows.T if wide else rows.T @ rows)
    own, square = vectors[:, -1], float(values[-1])
    other = (rows.T @ own if wide else rows @ own) / np.sqrt(max(square, np.finfo(float).tiny))
    return (own, square, other) if wide else (other, square, own)


def imputed(
    data: FloatArray, predictors: Sequence[Predictor], columns: Sequence[IntArray]
) -> tuple[FloatArray, float]:
    """Data (V, D) whose gaps are filled by the model of the whole, until that no longer moves.

    With it, by how much, mm, it still moves where it does not settle; otherwise 0.
    """
    gaps = ~np.isfinite(data)
    full = np.where(gaps, np.nanmean(data, axis=0), data)
    for _ in range(_ROUNDS):
        steps = guided(full, predictors, columns)
        after = np.where(gaps, steps.mean + steps.scores @ steps.modes, data)
        moved, full = float(np.abs(after - full).max()), after
        if moved < _SETTLED:
            return full, 0.0
    return full, moved
