"""Meshes cut off at a plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Cut:
    """Part of a mesh that is before a plane.

    Parameters
    ----------
    faces : (M, 3) int32
        Facets of this part, wound as those of the whole.
    first, second : (K,) int
        Vertices of the whole between which those of the part lie; the whole's own come first.
    share : (K,) float64
        How far from the first to the second each lies, 0 to 1.
    """

    faces: NDArray[np.int32]
    first: NDArray[np.int64]
    second: NDArray[np.int64]
    share: FloatArray

    def of(self, values: NDArray[np.floating]) -> FloatArray:
        """Values (K, C) of this part's vertices, from those (N, C) of the whole's."""
        start = np.asarray(values[self.first], np.float64)
        return start + self.share[:, None] * (values[self.second] - start)


def cut_off(faces: NDArray[np.int32], height: FloatArray) -> Cut:
    """Leave out what is behind a plane of a mesh.

    Parameters
    ----------
    faces : (M, 3) int32
    height : (N,) float64
        Of the vertices before the plane; below zero behind it.
    """
    behind = height[faces] < 0
    kept = [faces[~behind.any(axis=1)]]
    first, second = np.arange(len(height)), np.arange(len(height))
    for lone_behind in (False, True):
        crossing = behind.sum(axis=1) == (1 if lone_behind else 2)
        lone = (behind[crossing] == lone_behind).argmax(axis=1)
        turned = (lone[:, None] + np.arange(3)) % 3  # the lone corner first, wound as before
        a, b, c = np.take_along_axis(faces[crossing], turned, axis=1).T
        ab, ac = len(first) + np.arange(2 * len(a)).reshape(2, -1)
        first, second = np.concatenate([first, a, a]), np.concatenate([second, b, c])
        new = [(ab, b, c), (ab, c, ac)] if lone_behind else [(a, ab, ac)]
        kept += [np.column_stack(corners) for corners in new]
    fall = height[first] - height[second]
    share = np.divide(height[first], fall, out=np.zeros(len(first)), where=first != second)
    return Cut(np.concatenate(kept).astype(np.int32), first, second, share)
