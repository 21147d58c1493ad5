"""Make the lips of every person meet at rest.

The macro targets leave the lips of the average person up to 1 mm apart. Where
they should meet is known from the lip grid, so the height that is missing is a
linear function of the vertices, and so is the displacement that takes it away;
applied to the average and to every identity target, it seals all their mixes.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree
from speaker_mesh import CONTACT_RING, INNER_MOUTH, Head

OVERLAP = 0.8  # mm by which the upper lip's lower edge lies below the lower lip's upper edge
REACH = 4.0  # mm, how far into the mouth the displacement fades
ROUNDS = 12


def pairing(along: np.ndarray, onto: np.ndarray) -> sparse.csr_matrix:
    """Return the matrix that interpolates values at increasing `onto` to the places `along`."""
    right = np.clip(np.searchsorted(onto, along), 1, len(onto) - 1)
    share = np.clip((along - onto[right - 1]) / (onto[right] - onto[right - 1]), 0.0, 1.0)
    rows = np.arange(len(along))
    return sparse.csr_matrix(
        (
            np.concatenate([1 - share, share]),
            (np.tile(rows, 2), np.concatenate([right - 1, right])),
        ),
        (len(along), len(onto)),
    )


def spread(head: Head, weld_of: np.ndarray, columns: np.ndarray) -> sparse.csr_matrix:
    """Return the (V, contact vertices) matrix that carries a contact's displacement around.

    Over the lip grid the weight falls from one at the contact to zero at the outermost ring,
    along each spoke; behind the seam it fades over `REACH`.
    """
    rings = head.lips.vertices.shape[0]
    weight = np.minimum(np.arange(rings) / CONTACT_RING, 1.0)
    weight = weight * weight * (3 - 2 * weight)
    n = weld_of.max() + 1
    entries = {}
    for j, spoke in enumerate(columns):
        for r in range(rings):
            entries[int(weld_of[head.lips.vertices[r, spoke]])] = (j, weight[r])
    taken = np.isin(np.arange(n), weld_of[head.lips.vertices])
    seam = head.lips.vertices[-1, columns]
    inner = np.unique(head.faces[head.facet_class == INNER_MOUTH])
    side = cKDTree(head.vertices[head.lips.vertices[-1]]).query(head.vertices[inner])[1]
    distance, nearest = cKDTree(head.vertices[seam]).query(head.vertices[inner])
    for v, j, d, s in zip(inner, nearest, distance, side, strict=True):
        if s in columns and not taken[weld_of[v]] and d < 3 * REACH:
            entries[int(weld_of[v])] = (int(j), float(np.exp(-((d / REACH) ** 2))))
    rows = np.array(list(entries))
    table = np.array(list(entries.values()))
    matrix = sparse.csr_matrix((table[:, 1], (rows, table[:, 0].astype(int))), (n, len(columns)))
    return matrix[weld_of]


class Seal:
    """The operator that closes the lips.

    Parameters
    ----------
    head : Head
        The head, for its lip grid and the average shape.
    """

    def __init__(self, head: Head) -> None:
        grid, left = head.lips.vertices, head.lips.left
        up = np.arange(1, left)
        low = np.arange(left + 1, grid.shape[1])[::-1]
        self.upper, self.lower = grid[CONTACT_RING, up], grid[CONTACT_RING, low]
        x = head.vertices[:, 0]
        self.to_lower = pairing(x[self.upper], x[self.lower])
        self.to_upper = pairing(x[self.lower], x[self.upper])
        self.spread_upper = spread(head, head.weld, up)
        self.spread_lower = spread(head, head.weld, low)

    def gap(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return upper minus lower height (mm) at the upper and at the lower contact vertices."""
        upper, lower = y[self.upper], y[self.lower]
        return upper - self.to_lower @ lower, self.to_upper @ upper - lower

    def correction(self, y: np.ndarray, wanted: float) -> np.ndarray:
        """Return the (V,) change of height (mm) after which the gap is `wanted`."""
        change = np.zeros(len(y))
        for _ in range(ROUNDS):
            at_upper, at_lower = self.gap(y + change)
            change -= self.spread_upper @ (0.5 * (at_upper - wanted))
            change += self.spread_lower @ (0.5 * (at_lower - wanted))
        return change

    def seal(self, vertices: np.ndarray, wanted: float) -> np.ndarray:
        """Return the vertices (or displacements) with the gap set to `wanted` mm."""
        sealed = vertices.copy()
        sealed[:, 1] += self.correction(vertices[:, 1], wanted)
        return sealed
