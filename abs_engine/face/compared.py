"""The parts of a moving head that textures and local appearance are learned of and compared on."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.core.blocks import POSE, POSTURE, Blocks
from abs_engine.core.params import ParamSpec
from abs_engine.core.pose import PoseFrame, pose_and
from abs_engine.core.scene import Candidates, Scene
from abs_engine.core.settings import GENERAL
from abs_engine.face.appearance.visibility import Sighting

_POSE_KNOWN = 1e-3
"""1 / variance of the pose beforehand, per squared first step: next to nothing."""


@dataclass(frozen=True, eq=False)
class ComparedHead:
    """A moving head, and the parts of it that are compared.

    Parameters
    ----------
    scene : Scene
        The whole head; its P modes are the parameters, for one standard deviation.
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
    pivot : (3,) float64, mm, head frame
        Point that the head is turned about.
    """

    scene: Scene
    surface: Scene
    outer: Scene
    kept: IntArray
    marks: IntArray
    spec: ParamSpec
    pivot: FloatArray

    @cached_property
    def blocks(self) -> Blocks:
        """The pose, then the parameters."""
        return pose_and(self.spec)

    def moved(self, sighting: Sighting) -> Candidates:
        """A frame's pose and posture, then each of the 6 + P parameters moved by its first step."""
        here = self.blocks.vector({POSTURE: sighting.parameters})
        rows = np.vstack([here, here + np.diag(self.blocks.spec.scale)])
        return PoseFrame(sighting.pose, self.pivot).candidates(rows)

    @property
    def about(self) -> FloatArray:
        """Prior knowledge of the 6 + P parameters, 1 / variance per squared first step."""
        own = np.full(len(self.spec), GENERAL.mode_step**2)
        return self.blocks.vector({POSE: np.float64(_POSE_KNOWN), POSTURE: own})
