"""Linear shape models, X = X0 + M a: the form that both papers share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.face.shape.postures import Postures


@dataclass(frozen=True, eq=False)
class LinearShape:
    """Vertices as a linear function of parameters of unit variance.

    Parameters
    ----------
    mean : (V, 3) float32, mm, head frame
    modes : (P, V, 3) float32, mm for one standard deviation
    mixing : (P, N) float64
        The modes as combinations of N generators (face units, say); see `generators`.
    offset : (N,) float64
        Generator weights of the mean.
    variance : (P,) float64
        Share of the variance that each mode holds, 0 to 1.
    """

    mean: NDArray[np.float32]
    modes: NDArray[np.float32]
    mixing: FloatArray
    offset: FloatArray
    variance: FloatArray


def principal_shapes(
    neutral: NDArray[np.float32],
    generators: NDArray[np.float32],
    postures: Postures,
    n_modes: int,
    importance: FloatArray,
) -> LinearShape:
    """Principal components of shapes that linear generators make.

    Works in the space of the generators, which is exact and costs nothing: the covariance of the
    vertices is G' C G with C that of the postures. Raises `ParameterError` if more modes are asked
    for than the postures span.

    Parameters
    ----------
    neutral : (V, 3) float32, mm
    generators : (N, V, 3) float32, mm at weight 1
    postures : Postures
        Moments of the training shapes' generator weights, N.
    importance : (V,) float64
        How much the displacement of a vertex counts in the variance.
    """
    root, rank = _covariance_root(postures.covariance)
    if n_modes > rank:
        raise ParameterError(f"{n_modes} modes asked for, the postures span {rank}", "ask for less")
    weighted = generators.reshape(len(generators), -1) * np.repeat(np.sqrt(importance), 3)
    gram = np.asarray(weighted @ weighted.T, np.float64)
    values, vectors = np.linalg.eigh(root.T @ gram @ root)
    order = np.argsort(values)[::-1][:n_modes]
    mixing = (root @ vectors[:, order]).T
    mixing *= np.sign(mixing[np.arange(n_modes), np.abs(mixing).argmax(axis=1)])[:, None]
    mean = neutral + np.tensordot(postures.mean, generators, 1)
    return LinearShape(
        mean.astype(np.float32),
        np.tensordot(mixing, generators, 1).astype(np.float32),
        mixing,
        postures.mean,
        values[order] / values.sum(),
    )


def _covariance_root(covariance: FloatArray) -> tuple[FloatArray, int]:
    values, vectors = np.linalg.eigh(covariance)
    keep = values > 1e-9 * values.max()
    return vectors[:, keep] * np.sqrt(values[keep]), int(keep.sum())
