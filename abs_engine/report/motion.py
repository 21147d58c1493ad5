"""A moving mesh in few numbers: a mean and modes, which a browser adds up frame by frame."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.tracking.results.run_mesh import LinearSurface

LARGEST_ERROR_MM = 0.05
"""No coordinate of a mesh is farther from the original than this."""

_COLUMNS = 4096


def compress(vertices: Callable[[int], NDArray[np.floating[Any]]], frames: int) -> LinearSurface:
    """The fewest principal components that give every coordinate back to `LARGEST_ERROR_MM`.

    Parameters
    ----------
    vertices : callable
        Gives the vertices (V, 3), mm, of a frame; NaN where there are none.
    """
    shape = vertices(0).shape
    moved = np.empty((frames, int(np.prod(shape))), np.float32)
    for frame in range(frames):
        moved[frame] = vertices(frame).ravel()
    known = np.isfinite(moved).all(axis=1)
    weights = np.full((frames, 1), np.nan, np.float32)
    if not known.any():
        return LinearSurface(
            np.zeros(shape, np.float32), np.zeros((1, *shape), np.float32), weights
        )
    moved = moved[known]
    mean = moved.mean(axis=0, dtype=np.float64).astype(np.float32)
    moved -= mean
    strengths, sides = _sides(moved)
    # as long as the mean square is too large, the largest is: begin behind that
    after = np.cumsum(strengths[::-1])[::-1] / moved.size
    count = max(1, int((after > LARGEST_ERROR_MM**2).sum()))
    left = moved - sides[:, :count] @ (sides[:, :count].T @ moved)
    while count < len(moved) and np.abs(left).max() > LARGEST_ERROR_MM:
        side = sides[:, count]
        left -= np.outer(side, side @ moved)
        count += 1
    modes = (sides[:, :count].T @ moved).reshape(count, *shape)
    weights = np.full((frames, count), np.nan, np.float32)
    weights[known] = sides[:, :count]
    return LinearSurface(mean.reshape(shape), modes, weights)


def _sides(moved: NDArray[np.float32]) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    """Squared singular values (T,) and left singular vectors (T, T) of (T, 3 V), falling.

    They are eigenvectors of the small matrix of inner products, which is summed in double
    precision, a part of the columns at a time.
    """
    products = np.zeros((len(moved), len(moved)))
    for start in range(0, moved.shape[1], _COLUMNS):
        part = moved[:, start : start + _COLUMNS].astype(np.float64)
        products += part @ part.T
    values, vectors = np.linalg.eigh(products)
    return np.maximum(values[::-1], 0), np.asarray(vectors[:, ::-1], np.float32)
