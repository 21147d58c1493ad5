"""Places of measured points on a head: the facets on which each may lie, and the nearest there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from abs_engine.core.arrays import FloatArray
from abs_engine.core.nearest import barycentric, nearest_in
from abs_engine.face.shape.dots import ShellPoints
from abs_engine.io.assets import Speaker
from abs_engine.learn.measured.settings import MEASURED_FACE

TEETH, LIPS, UPPER, LOWER = "lower_teeth", "lips", "upper_lip", "lower_lip"
"""Groups of points that say where on a head they lie; all others lie on the skin."""


@dataclass(frozen=True, eq=False)
class Sites:
    """Facets (F, 3) that points may lie on, of each part of the points, by their indices (K,)."""

    parts: tuple[tuple[NDArray[np.int64], NDArray[np.int32]], ...]

    @classmethod
    def of(
        cls, speaker: Speaker, names: Sequence[str], groups: Mapping[str, Sequence[str]]
    ) -> Sites:
        """By the groups of named points.

        Those of the lips may lie on the lips or, as beads around them do, on the skin; those of one
        lip are not on the other.
        """
        classes = [_classes(name, groups) for name in names]
        parts = []
        for own in dict.fromkeys(classes):
            at = np.array([k for k, other in enumerate(classes) if other == own], np.int64)
            parts.append((at, speaker.faces[speaker.facets_of(*own)]))
        return cls(tuple(parts))

    @property
    def count(self) -> int:
        """Number of points, N."""
        return sum(len(at) for at, _ in self.parts)

    def nearest(self, vertices: FloatArray, points: FloatArray) -> ShellPoints:
        """The places of a head (V, 3) that are nearest to points (N, 3), mm, of its frame."""
        corners, weights = np.zeros((self.count, 3), np.int32), np.zeros((self.count, 3))
        for at, facets in self.parts:
            corners[at], weights[at] = _nearest(vertices, facets, points[at])
        return ShellPoints(corners, weights)


def _classes(name: str, groups: Mapping[str, Sequence[str]]) -> tuple[str, ...]:
    """Facet classes that a point may lie on."""
    own = {group for group in (TEETH, LIPS, UPPER, LOWER) if name in groups.get(group, ())}
    if TEETH in own:
        return (TEETH,)
    red = own & {UPPER, LOWER} or ({UPPER, LOWER} if LIPS in own else set())
    return ("skin", *sorted(red))


def _nearest(
    vertices: FloatArray, facets: NDArray[np.int32], points: FloatArray
) -> tuple[NDArray[np.int32], FloatArray]:
    """Corners (K, 3) and barycentric weights (K, 3) of the nearest places on some facets."""
    triangles, count = vertices[facets], min(MEASURED_FACE.tried, len(facets))
    about = cKDTree(triangles.mean(axis=1)).query(points, count)[1].reshape(-1)
    tried, wanted = triangles[about], np.repeat(points, count, axis=0)
    found = nearest_in(tried, wanted)
    away = np.linalg.norm(found - wanted, axis=1).reshape(-1, count)
    best = np.arange(len(points)) * count + away.argmin(axis=1)
    weights = np.clip(barycentric(tried[best], found[best]), 0, 1)
    return facets[about[best]], weights
