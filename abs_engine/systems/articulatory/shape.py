"""A speaker's head moved by articulatory parameters, and which parts of it are compared."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from abs_engine.appearance.region import part
from abs_engine.appearance.sight import Sighting
from abs_engine.assets import Speaker
from abs_engine.compare.penalty import ImprobablePenalty
from abs_engine.geometry import Pose
from abs_engine.params import ParamSpec
from abs_engine.scene import Candidates, Scene
from abs_engine.shape.articulatory_model import ArticulatoryModel
from abs_engine.synth.corpus import SpokenCorpus
from abs_engine.systems.articulatory.build import Build, dense_head
from abs_engine.track.pose import PoseFrame, pose_spec

FloatArray = NDArray[np.float64]
STEP = 0.5
"""First step of a parameter, standard deviations, at a solver's step 1."""
BEYOND = 2.0
"""sd beyond the corpus' range to which a fit may go; the penalty holds it back earlier."""
_POSE_KNOWN = 1e-3
"""1 / variance of the pose beforehand, per squared first step: next to nothing."""
_UPPER = {"eyeBlink": 1.0, "brow": 0.25}
_STILL, _NEAR = 0.5, 6.0  # mm
_INSIDE = ("inner_mouth", "upper_teeth", "lower_teeth", "tongue")


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
    """

    model: ArticulatoryModel
    frame: Pose
    scene: Scene
    vertices: NDArray[np.int64]
    lips: NDArray[np.int64]
    surface: Scene
    outer: Scene
    kept: NDArray[np.int64]
    marks: NDArray[np.int64]
    spec: ParamSpec
    penalty: ImprobablePenalty
    neutral: FloatArray

    def points(self, alpha: FloatArray) -> FloatArray:
        """The model's points (N, 3), mm, head frame, at parameters (P,)."""
        modes = self.scene.modes[:, self.vertices]
        return np.asarray(self.scene.mean[self.vertices] + np.tensordot(alpha, modes, 1))

    def invert(self, points: FloatArray) -> FloatArray:
        """The direct inversion: parameters (..., P) of points (..., N, 3), mm, head frame."""
        return self.model.invert(self.frame.apply(points))

    @cached_property
    def full(self) -> ParamSpec:
        """Six parameters of pose, then the articulatory ones."""
        both, own = pose_spec(0), self.spec
        return ParamSpec(
            both.names + own.names, both.units + own.units, np.r_[both.scale, own.scale],
            np.r_[both.lower, own.lower], np.r_[both.upper, own.upper],
        )  # fmt: skip

    def moved(self, sighting: Sighting) -> Candidates:
        """A frame's pose and posture, then each of the 13 parameters moved by its first step."""
        here = np.concatenate([np.zeros(6), sighting.parameters])
        rows = np.vstack([here, here + np.diag(self.full.scale)])
        return PoseFrame(sighting.pose, self.pivot).candidates(rows)

    @property
    def about(self) -> FloatArray:
        """What is known of the 13 parameters beforehand, 1 / variance per squared first step."""
        own = len(self.spec.scale)
        return np.concatenate([np.full(6, _POSE_KNOWN), np.full(own, STEP**2)])

    @cached_property
    def pivot(self) -> FloatArray:
        """Middle of the lips' points, mm, head frame: heads are turned about it."""
        return np.asarray(self.scene.mean[self.vertices[self.lips]].mean(axis=0), np.float64)


def face_shape(speaker: Speaker, spoken: SpokenCorpus, built: Build, person: str) -> FaceShape:
    """The shape of a speaker from the corpus and its articulatory model.

    Parameters
    ----------
    speaker : Speaker
    spoken : SpokenCorpus
    built : Build
        Of `spoken`.
    person : str
        Whose skin it is.
    """
    dense = dense_head(built, spoken)
    scene = Scene(
        dense.mean, dense.modes, speaker.faces, speaker.uv,
        speaker.facet_class.astype(np.int32), speaker.texture(person),
    )  # fmt: skip
    kept_names = set(built.model.names)
    own = [k for k, name in enumerate(spoken.chosen.names) if name in kept_names]
    vertices = np.asarray(spoken.chosen.vertices[own], np.int64)
    lips = set(built.model.groups["lips"])
    at_lips = np.flatnonzero([name in lips for name in built.model.names])
    marks = _marks(speaker)
    surface = _facets(speaker, marks)
    inside = np.isin(speaker.facet_class, [speaker.class_id(name) for name in _INSIDE])
    outer, kept = part(scene, surface | inside)
    frame = spoken.corpus.frame
    neutral = spoken.neutral[vertices].astype(np.float64)
    lower, upper = built.alpha.min(axis=0) - BEYOND, built.alpha.max(axis=0) + BEYOND
    names = built.model.parameters
    return FaceShape(
        built.model, frame, scene, vertices, at_lips.astype(np.int64),
        part(scene, surface)[0], outer, kept, marks,
        ParamSpec(names, ("sd",) * len(names), np.full(len(names), STEP), lower, upper),
        ImprobablePenalty.of_corpus(built.alpha),
        built.model.invert(frame.apply(neutral)),
    )  # fmt: skip


def _marks(speaker: Speaker) -> NDArray[np.int64]:
    """Vertices of face and lips that blinks and brows leave where they are."""
    listed = np.union1d(speaker.points["face"], speaker.points["lips"])
    return np.asarray(listed[_still(speaker)[listed]], np.int64)


def _still(speaker: Speaker) -> NDArray[np.bool_]:
    """Which vertices (V,) blinks and brows leave where they are."""
    moved = np.zeros(len(speaker.vertices))
    for unit, offsets in zip(speaker.unit_names, speaker.units, strict=True):
        weight = max((w for name, w in _UPPER.items() if unit.startswith(name)), default=0.0)
        if weight:
            moved = np.maximum(moved, weight * np.linalg.norm(offsets.astype(np.float64), axis=1))
    return np.asarray(moved < _STILL)


def _facets(speaker: Speaker, marks: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Facets of skin between the marks, which lie 4 mm apart, and all of the lips."""
    lips = [speaker.class_id(name) for name in ("upper_lip", "lower_lip")]
    place = speaker.vertices.astype(np.float64)
    near = cKDTree(place[marks]).query(place)[0] < _NEAR
    within = (near & _still(speaker))[speaker.faces].all(axis=1)
    skin = speaker.facet_class == speaker.class_id("skin")
    return np.asarray((within & skin) | np.isin(speaker.facet_class, lips))
