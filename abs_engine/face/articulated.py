"""A speaker's head moved by articulatory parameters, and which parts of it are compared."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Scene
from abs_engine.face.compared import ComparedHead
from abs_engine.face.penalty import ImprobablePenalty
from abs_engine.face.shape.articulatory_model import ArticulatoryModel


@dataclass(frozen=True, eq=False)
class FaceShape(ComparedHead):
    """A speaker's head moved by articulatory parameters, and the parts of it that are compared.

    Parameters
    ----------
    scene, surface, outer, kept, marks, spec, pivot
        As of `ComparedHead`; `pivot` is `middle` of the lips.
    frame : Pose
        Head frame to the frame of the corpus.
    vertices : (N,) int64
        The model's points on the head.
    lips : (K,) int64
        Which of the points are lips or beads around them.
    neutral : (P,) float64
        The person at rest, by the direct inversion.
    rings : mapping of str to int32 arrays
        The lips' contours, points and corners, as vertices of the head: see `face.base.Face`.
    regions : tuple of (str or None)
        What colour class the facets of each class show.
    """

    model: ArticulatoryModel
    frame: Pose
    vertices: IntArray
    lips: IntArray
    penalty: ImprobablePenalty
    neutral: FloatArray
    rings: Mapping[str, NDArray[np.int32]]
    regions: tuple[str | None, ...]

    def points(self, alpha: FloatArray) -> FloatArray:
        """The model's points (N, 3), mm, head frame, at parameters (P,)."""
        modes = self.scene.modes[:, self.vertices]
        return np.asarray(self.scene.mean[self.vertices] + np.tensordot(alpha, modes, 1))

    def invert(self, points: FloatArray) -> FloatArray:
        """The direct inversion: parameters (..., P) of points (..., N, 3), mm, head frame."""
        return self.model.invert(self.frame.apply(points))


def middle(scene: Scene, vertices: IntArray) -> FloatArray:
    """Middle (3,) of some vertices of a head at rest, mm, head frame; the nearest of wrong ones."""
    return np.asarray(scene.mean.take(vertices, axis=0, mode="clip").mean(axis=0), np.float64)
