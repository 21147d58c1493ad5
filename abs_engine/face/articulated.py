"""A speaker's head moved by articulatory parameters, and which parts of it are compared."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.core.blocks import Blocks
from abs_engine.core.geometry import Pose
from abs_engine.core.params import ParamSpec
from abs_engine.core.pose import pose_and
from abs_engine.core.scene import Scene
from abs_engine.face.compared import ComparedHead
from abs_engine.face.penalty import ImprobablePenalty
from abs_engine.face.shape.articulatory_model import ArticulatoryModel


@dataclass(frozen=True, eq=False)
class FaceShape:
    """A speaker's head moved by articulatory parameters, and the parts of it that are compared.

    Parameters
    ----------
    model : ArticulatoryModel
    frame : Pose
        Head frame to the frame of the corpus.
    scene : Scene
        The whole head; its modes are the parameters, for one standard deviation.
    vertices : (N,) int64
        The model's points on the head.
    lips : (K,) int64
        Which of the points are lips or beads around them.
    surface : Scene
        S: facets of skin and lips below the eyes.
    outer : Scene
        The same and the inside of the mouth, which hides and is hidden.
    kept : (V',) int64
        The head's vertices that are in `outer`.
    marks : (L,) int64
        Vertices of the head that may carry local appearance: skin and lips of `surface`.
    spec : ParamSpec
        Names, first steps and bounds of the parameters.
    penalty : ImprobablePenalty
    neutral : (P,) float64
        The person at rest, by the direct inversion.
    rings : mapping of str to int32 arrays
        The lips' contours, points and corners, as vertices of the head: see `face.base.Face`.
    regions : tuple of (str or None)
        What colour class the facets of each class show.
    """

    model: ArticulatoryModel
    frame: Pose
    scene: Scene
    vertices: IntArray
    lips: IntArray
    surface: Scene
    outer: Scene
    kept: IntArray
    marks: IntArray
    spec: ParamSpec
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

    @cached_property
    def blocks(self) -> Blocks:
        """The pose, then the articulatory parameters."""
        return pose_and(self.spec)

    @cached_property
    def compared(self) -> ComparedHead:
        """The parts that appearance is learned of."""
        return ComparedHead(
            self.scene, self.surface, self.outer, self.kept, self.marks, self.spec, self.pivot
        )

    @cached_property
    def pivot(self) -> FloatArray:
        """Middle of the lips' points, mm, head frame: heads are turned about it."""
        return np.asarray(self.scene.mean[self.vertices[self.lips]].mean(axis=0), np.float64)
