"""Points of a shell between its nodes: where dots are on it, and what of it they see."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.nearest import barycentric, nearest_on_facets

AXES = "xyz"


@dataclass(frozen=True, eq=False)
class ShellPoints:
    """Points on the facets of a shell, or of a head: their nodes and barycentrics, (K, 3) each.

    Weights are 1, 0, 0 for a node.
    """

    corners: NDArray[np.int32]
    weights: FloatArray

    def __len__(self) -> int:
        """Return the number of points, K."""
        return len(self.corners)

    def at(self, nodes: NDArray[np.floating]) -> FloatArray:
        """The points (..., K, 3), of nodes (..., N, 3); of displacements as well as of places."""
        there = np.asarray(nodes, np.float64)[..., self.corners, :]
        return np.asarray(np.einsum("...nkd,nk->...nd", there, self.weights))

    def subset(self, which: NDArray[np.integer] | slice) -> ShellPoints:
        """Some of the points."""
        return ShellPoints(self.corners[which], self.weights[which])

    def rows(self, nodes: int, coordinates: str = AXES) -> sparse.csr_matrix:
        """W (K C, 3N): what the coordinates of the points are of those of the shell's N nodes.

        The C coordinates, such as "yz", of the first point, then those of the second, ... Raises
        `ParameterError` if a coordinate is none, or named twice.
        """
        if not coordinates or len({*coordinates} & {*AXES}) != len(coordinates):
            raise ParameterError(
                f"'{coordinates}' are not coordinates", "choose some of x, y and z"
            )
        basis = np.eye(3)[[AXES.index(c) for c in coordinates]]
        return self.projected(nodes, basis)

    def projected(self, nodes: int, basis: FloatArray) -> sparse.csr_matrix:
        """W (K C, 3N) for the points' coordinates along any directions (C, 3)."""
        basis = np.asarray(basis, np.float64)
        count, each = len(self), len(basis)
        row = (np.arange(count)[:, None] * each + np.arange(each))[:, :, None, None]
        column = (3 * self.corners[:, :, None] + np.arange(3))[:, None]
        value = self.weights[:, None, :, None] * basis[None, :, None, :]
        row, column = np.broadcast_to(row, value.shape), np.broadcast_to(column, value.shape)
        entries = value.ravel(), (row.ravel(), column.ravel())
        return sparse.csr_matrix(entries, shape=(count * each, 3 * nodes))


def nearest_points(
    nodes: FloatArray, faces: NDArray[np.integer], points: NDArray[np.floating]
) -> ShellPoints:
    """Points of a shell, of nodes (N, 3), mm, that are nearest to points (K, 3), mm, in space.

    They may lie on the facets (M, 3).
    """
    facet, place = nearest_on_facets(nodes[faces], np.asarray(points, np.float64))
    weights = barycentric(nodes[faces[facet]], place)
    return ShellPoints(faces[facet].astype(np.int32), np.clip(weights, 0, 1))
