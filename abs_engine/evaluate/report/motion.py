"""A moving mesh in few numbers: a mean and modes, which a browser adds up frame by frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

LARGEST_ERROR_MM = 0.05
"""No coordinate of a mesh is farther from the original than this."""


@dataclass(frozen=True, eq=False)
class LinearMotion:
    """Vertices(t) = mean + sum over r of weights[t, r] modes[r].

    Parameters
    ----------
    mean : (V, 3) float32, mm
    modes : (R, V, 3) float32
    weights : (T, R) float32
        NaN in frames without a mesh.
    """

    mean: NDArray[np.float32]
    modes: NDArray[np.float32]
    weights: NDArray[np.float32]

    def vertices(self, frame: int) -> NDArray[np.float32]:
        """Vertices (V, 3) of a frame; NaN where there is no mesh."""
        moved = np.tensordot(self.weights[frame], self.modes, 1)
        return np.asarray(self.mean + moved, np.float32)


def compress(
    vertices: Callable[[int], NDArray[np.floating[Any]]],
    frames: int,
    *,
    largest: float = LARGEST_ERROR_MM,
) -> LinearMotion:
    """The fewest principal components that give every coordinate back well enough.

    Parameters
    ----------
    vertices : callable
        Gives the vertices (V, 3), mm, of a frame; NaN where there are none.
    frames : int
    largest : float, mm
        The largest error that is allowed.
    """
    first = np.asarray(vertices(0), np.float64)
    moved = np.stack([np.asarray(vertices(k), np.float64).ravel() for k in range(frames)])
    found = np.isfinite(moved).all(axis=1)
    if not found.any():
        nothing = np.zeros((1, *first.shape), np.float32)
        return LinearMotion(nothing[0], nothing, np.full((frames, 1), np.nan, np.float32))
    mean = moved[found].mean(axis=0)
    moved = moved[found] - mean
    # the eigenvectors of the small matrix of frames are those of the large one of vertices
    values, sides = np.linalg.eigh(moved @ moved.T)
    order = np.argsort(values)[::-1]
    count, left = 0, moved.copy()
    while count == 0 or (count < len(order) and np.abs(left).max() > largest):
        side = sides[:, order[count]]
        left -= np.outer(side, side @ moved)
        count += 1
    sides = sides[:, order[:count]]
    modes = (sides.T @ moved).reshape(count, *first.shape)
    weights = np.full((frames, count), np.nan, np.float32)
    weights[found] = sides
    return LinearMotion(
        mean.reshape(first.shape).astype(np.float32), modes.astype(np.float32), weights
    )

