"""The whole head moved by articulatory parameters that were learned from points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError, TooFewPointsError
from abs_engine.face.shape.linear import LinearShape


def dense_units(
    alpha: FloatArray, weights: FloatArray, neutral: NDArray[np.floating],
    units: NDArray[np.floating],
) -> LinearShape:  # fmt: skip
    """Full heads by regression of their face units' weights on the parameters of the same visemes.

    Parameters
    ----------
    alpha : (V, P) float64
        Parameters, standard deviations.
    weights : (V, U) float64
        Face-unit weights of the visemes.
    neutral : (M, 3) float, mm, head frame
    units : (U, M, 3) float, mm at weight 1

    Returns
    -------
    LinearShape
        Mean (M, 3) and modes (P, M, 3) in the head frame. Its generators are face-unit weights.

    Raises
    ------
    ParameterError
        If the arrays do not fit together.
    TooFewPointsError
        If the visemes do not determine the modes.
    """
    alpha, weights = np.asarray(alpha, np.float64), np.asarray(weights, np.float64)
    if len(alpha) != len(weights) or weights.shape[1:] != units.shape[:1]:
        raise ParameterError(
            f"parameters {alpha.shape}, weights {weights.shape} and units {units.shape} do not fit",
            "give (V, P), (V, U) and (U, M, 3)",
        )
    fitted = _solver(alpha) @ weights
    used = np.flatnonzero(weights.any(axis=0))
    deltas = units[used].astype(np.float64)
    mean = neutral + np.tensordot(fitted[0, used], deltas, 1)
    modes = np.asarray(np.tensordot(fitted[1:][:, used], deltas, 1), np.float64)
    heads = np.asarray(np.tensordot(weights[:, used], deltas, 1), np.float64)
    return LinearShape(
        mean.astype(np.float32), modes.astype(np.float32), fitted[1:], fitted[0],
        _shares(alpha, modes, heads),
    )  # fmt: skip


def _solver(alpha: FloatArray) -> FloatArray:
    """Matrix (1 + P, V) from values in the visemes to those at 0 and their slopes."""
    design = np.column_stack([np.ones(len(alpha)), alpha])
    if np.linalg.matrix_rank(design) < design.shape[1]:
        raise TooFewPointsError(
            f"{len(alpha)} visemes do not determine {alpha.shape[1]} modes", "give more visemes"
        )
    return np.asarray(np.linalg.pinv(design), np.float64)


def _shares(alpha: FloatArray, modes: FloatArray, heads: FloatArray) -> FloatArray:
    """Share (P,) of the heads' variance that each mode holds, as if the others were not."""
    centred = heads - heads.mean(axis=0)
    total = max(float((centred**2).sum()), 1e-300) / (len(heads) - 1)
    each = (modes.reshape(len(modes), -1) ** 2).sum(axis=1) * alpha.var(axis=0, ddof=1)
    return np.asarray(each / total, np.float64)
