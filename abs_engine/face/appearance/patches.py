"""Points of the surface with the facets around them: all that is needed to place and see them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import Candidates, Scene


@dataclass(frozen=True, eq=False)
class Patches:
    """N vertices of a scene and the vertices (K) of the facets around them.

    Parameters
    ----------
    mean : (K, 3) float64, mm, head frame
    modes : (P, K, 3) float64, mm per unit of weight
    kept : (K,) int64
        Vertices of the scene.
    points : (N,) int64
        Which of the K vertices are the points.
    facets : (M, 3) int64
        Facets around the points, as indices of the K vertices, those of a point together.
    starts, counts : (N,) int64
        The first facet of each point, and how many it has.
    """

    mean: FloatArray
    modes: FloatArray
    kept: IntArray
    points: IntArray
    facets: IntArray
    starts: IntArray
    counts: IntArray

    @classmethod
    def around(cls, scene: Scene, vertices: NDArray[np.integer]) -> Patches:
        """The patches of some vertices (N,) of a scene.

        Raises `ParameterError` if a vertex is none of the scene's, or has no facet.
        """
        chosen = np.asarray(vertices, np.int64)
        if chosen.ndim != 1 or len(chosen) == 0 or not (0 <= chosen.min() <= chosen.max()):
            raise ParameterError(
                "the points are not a list of vertices", "give indices of the mesh"
            )
        if chosen.max() >= len(scene.mean):
            raise ParameterError(
                f"point {chosen.max()} is none of the {len(scene.mean)} vertices",
                "take points and mesh of the same speaker",
            )
        corner = scene.faces.ravel()
        order = np.argsort(corner, kind="stable")
        first = np.searchsorted(corner[order], chosen)
        count = np.searchsorted(corner[order], chosen, side="right") - first
        if not count.all():
            lost = chosen[count == 0][0]
            raise ParameterError(f"vertex {lost} belongs to no facet", "choose other points")
        facet = np.concatenate([order[a : a + n] // 3 for a, n in zip(first, count, strict=True)])
        corners = scene.faces[facet].astype(np.int64)
        kept, back = np.unique(corners, return_inverse=True)
        return cls(
            scene.mean[kept].astype(np.float64),
            scene.modes[:, kept].astype(np.float64),
            kept,
            np.searchsorted(kept, chosen),
            back.reshape(-1, 3),
            np.cumsum(count) - count,
            count,
        )

    def placed(self, candidates: Candidates, index: int) -> FloatArray:
        """Places (K, 3), mm, camera frame, of the kept vertices in one candidate of a batch."""
        shape = self.mean + np.tensordot(candidates.weights[index], self.modes, 1)
        rotation, shift = candidates.rotations[index], candidates.translations[index]
        return np.asarray(shape @ rotation.T + shift)

    def surface(self, vertices: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points and normals (N, 3) from the places (K, 3) of the kept vertices."""
        a, b, c = (vertices[self.facets[:, k]] for k in range(3))
        normals = np.add.reduceat(np.cross(b - a, c - a), self.starts, axis=0)
        return vertices[self.points], normals
