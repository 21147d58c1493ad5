"""Forces on the nodes of a face, as work on its parameters and as a first step under them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.blocks import POSE, Blocks
from abs_engine.core.errors import ParameterError
from abs_engine.core.pose import PoseFrame
from abs_engine.core.scene import Candidates, Scene
from abs_engine.fit.evidence import Pushing, Term, finite
from abs_engine.fit.settings import HEAD_FIT


@dataclass(frozen=True, eq=False)
class Forces:
    """Forces of the terms that have them, over all parameters (6 + P,): pose, then weights."""

    frame: PoseFrame
    blocks: Blocks
    terms: Mapping[str, Term]

    def generalised(self, candidate: Candidates) -> FloatArray:
        """Work (6 + P,) of all forces for a unit of each parameter.

        Raises `ParameterError` if no term has forces.
        """
        pushed = [self._work(term, candidate) for term in self._pushing()]
        finite(", ".join(self.terms), "forces", *pushed)
        return np.asarray(np.sum(pushed, axis=0))

    def strides(self, step: FloatArray, candidate: Candidates) -> FloatArray:
        """A step (6 + P,) with the pose's part and the weights' part each of a first stride."""
        scene = self._pushing()[0].scene
        pose, weights = (self.blocks.part(step, POSE), step[self.blocks.places[POSE].stop :])
        moved = np.tensordot(weights, scene.modes.astype(np.float64), 1)
        weights = weights * (HEAD_FIT.first_stride / max(_farthest(moved), 1e-9))
        turned = np.cross(pose[:3], self._arms(scene, candidate)) + pose[3:]
        pose = pose * min(1.0, HEAD_FIT.first_stride / max(_farthest(turned), 1e-9))
        return np.asarray(np.r_[pose, weights])

    def _pushing(self) -> list[Pushing]:
        """The terms that have forces."""
        found = [term for term in self.terms.values() if isinstance(term, Pushing)]
        if not found:
            raise ParameterError(
                f"no evidence among {', '.join(self.terms)} has forces",
                "choose a driver that needs none, such as simplex",
            )
        return found

    def _work(self, term: Pushing, candidate: Candidates) -> FloatArray:
        """Work (6 + P,) of a term's forces for a unit of each parameter."""
        forces, rotation = term.forces(candidate), candidate.rotations[0]
        modes = term.scene.modes.astype(np.float64)
        weights = np.tensordot(modes, forces @ rotation, ([1, 2], [0, 1]))
        arm = self._arms(term.scene, candidate)
        turns = np.cross(arm, forces).sum(axis=0)
        return np.concatenate([turns, forces.sum(axis=0), weights])

    def _arms(self, scene: Scene, candidate: Candidates) -> FloatArray:
        """Vertices (V, 3) from the point that the pose turns about, camera axes, mm."""
        vertices = scene.vertices(candidate.weights[0])
        return np.asarray((vertices - self.frame.pivot) @ candidate.rotations[0].T)


def _farthest(moved: FloatArray) -> float:
    """Length, mm, of the longest of some displacements (V, 3)."""
    return float(np.linalg.norm(moved, axis=1).max())
