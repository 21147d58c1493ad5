"""The parts of a speaker's head that are compared, and how a corpus moves them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from abs_engine.core.arrays import BoolArray, FloatArray, IntArray
from abs_engine.core.geometry import Pose
from abs_engine.core.params import ParamSpec
from abs_engine.core.scene import Scene
from abs_engine.core.settings import GENERAL
from abs_engine.face.appearance.region import part
from abs_engine.face.articulated import FaceShape, middle
from abs_engine.face.compared import ComparedHead
from abs_engine.face.head import colour_classes
from abs_engine.face.penalty import ImprobablePenalty
from abs_engine.face.rings import contours
from abs_engine.face.schema import BROWS, Pair, units_of
from abs_engine.io.assets import Speaker
from abs_engine.learn.articulatory import Build, dense_head
from abs_engine.learn.settings import LEARNING
from abs_engine.learn.spoken import SpokenCorpus

_UPPER = dict.fromkeys(units_of(Pair.EYE_BLINK), LEARNING.blink) | dict.fromkeys(
    BROWS, LEARNING.brow
)
_INSIDE = ("inner_mouth", "upper_teeth", "lower_teeth", "tongue")


def face_shape(speaker: Speaker, spoken: SpokenCorpus, built: Build, person: str) -> FaceShape:
    """The shape of a speaker from a corpus and its articulatory model, with a person's skin."""
    dense = dense_head(built, spoken)
    kept_names = set(built.model.names)
    own = [k for k, name in enumerate(spoken.chosen.names) if name in kept_names]
    vertices = np.asarray(spoken.chosen.vertices[own], np.int64)
    frame = spoken.corpus.frame
    neutral = built.model.invert(frame.apply(spoken.neutral[vertices].astype(np.float64)))
    texture = speaker.texture(person)
    return shape_of(speaker, built, dense.mean, dense.modes, frame, vertices, neutral, texture)


def shape_of(
    speaker: Speaker,
    built: Build,
    mean: NDArray[np.float32],
    modes: NDArray[np.float32],
    frame: Pose,
    vertices: IntArray,
    neutral: FloatArray,
    texture: NDArray[np.uint8],
) -> FaceShape:
    """The shape of a head with a speaker's mesh that the parameters of a model move.

    `mean` (V, 3) and `modes` (P, V, 3) are in mm, head frame; `frame` leads from there to that of
    the corpus; `vertices` (N,) are the model's points on the head; `neutral` (P,) is the person at
    rest.
    """
    classes = speaker.facet_class.astype(np.int32)
    scene = Scene(mean, modes, speaker.faces, speaker.uv, classes, texture)
    lips = set(built.model.groups["lips"])
    at_lips = np.flatnonzero([name in lips for name in built.model.names]).astype(np.int64)
    surface, outer, kept, marks = _parts(speaker, scene)
    lower = built.alpha.min(axis=0) - LEARNING.beyond
    upper = built.alpha.max(axis=0) + LEARNING.beyond
    names = built.model.parameters
    spec = ParamSpec(
        names, ("sd",) * len(names), np.full(len(names), GENERAL.mode_step), lower, upper
    )
    return FaceShape(
        scene, surface, outer, kept, marks, spec, middle(scene, vertices[at_lips]),
        built.model, frame, vertices, at_lips, ImprobablePenalty.of_corpus(built.alpha),
        neutral, contours(speaker), colour_classes(speaker),
    )  # fmt: skip


def compared_head(
    speaker: Speaker, scene: Scene, spec: ParamSpec, pivot: FloatArray
) -> ComparedHead:
    """The parts of a head, with a speaker's mesh, that are compared, whatever moves it.

    The scene is the whole head, whose modes are the parameters of `spec`; it is turned about
    `pivot` (3,), mm, head frame.
    """
    surface, outer, kept, marks = _parts(speaker, scene)
    return ComparedHead(scene, surface, outer, kept, marks, spec, pivot)


def _parts(speaker: Speaker, scene: Scene) -> tuple[Scene, Scene, IntArray, IntArray]:
    """Skin and lips of a head; that with what stands in the mouth, its vertices (V',) and marks."""
    listed = _marks(speaker)
    surface = _facets(speaker, listed)
    outer, kept = part(scene, surface | speaker.facets_of(*_INSIDE))
    marks = listed[np.isin(listed, kept)]  # a few have no facet that stays where it is
    return part(scene, surface)[0], outer, kept, marks


def _marks(speaker: Speaker) -> IntArray:
    """Vertices of face and lips that blinks and brows leave where they are."""
    listed = np.union1d(speaker.points["face"], speaker.points["lips"])
    return np.asarray(listed[_still(speaker)[listed]], np.int64)


def _still(speaker: Speaker) -> BoolArray:
    """Mask of the vertices (V,) that blinks and brows leave where they are."""
    moved = np.zeros(len(speaker.vertices))
    for unit, offsets in zip(speaker.unit_names, speaker.units, strict=True):
        if weight := _UPPER.get(unit, 0.0):
            moved = np.maximum(moved, weight * np.linalg.norm(offsets.astype(np.float64), axis=1))
    return np.asarray(moved < LEARNING.still)


def _facets(speaker: Speaker, marks: IntArray) -> BoolArray:
    """Facets of skin between the marks, which lie 4 mm apart, and all of the lips."""
    place = speaker.vertices.astype(np.float64)
    near = cKDTree(place[marks]).query(place)[0] < LEARNING.near
    within = (near & _still(speaker))[speaker.faces].all(axis=1)
    lips = speaker.facets_of("upper_lip", "lower_lip")
    return np.asarray((within & speaker.facets_of("skin")) | lips)
