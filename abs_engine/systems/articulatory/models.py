"""A speaker's talking face: articulatory shape and the four appearance models of the paper."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from abs_engine.appearance.atlas import fitting_size, lay_atlas
from abs_engine.appearance.choose import N_POINTS, choose_points
from abs_engine.appearance.local import LocalModel, learn_local
from abs_engine.appearance.region import part
from abs_engine.appearance.sight import Sighting
from abs_engine.appearance.texture import TextureModel, learn_texture
from abs_engine.assets import Speaker
from abs_engine.camera import Camera
from abs_engine.compare.penalty import ExponentialPenalty
from abs_engine.errors import ParameterError
from abs_engine.geometry import Pose
from abs_engine.params import ParamSpec
from abs_engine.scene import Renderer, Scene
from abs_engine.shape.articulatory_model import ArticulatoryModel
from abs_engine.synth.corpus import SpokenCorpus
from abs_engine.systems.articulatory.build import Build, dense_head
from abs_engine.systems.articulatory.filmed import VisemePictures

FloatArray = NDArray[np.float64]
TEXTURES, LOCALS = ("tex_lin", "tex_cst"), ("la_lin", "la_cst")
MODELS = ("tex_lin", "tex_cst", "la_lin", "la_cst")
"""Appearance models, in the order of figure 6."""
SPACING = 4.0
"""mm between the points of local appearance, at least."""
FINEST = 1.0
"""Drawn pixels per mm of local appearance, at most: its filters are to reach 2 mm and more, or a
fit that starts far away does not come home."""
STEP = 0.5
"""First step of a parameter, standard deviations, at a solver's step 1."""
BEYOND = 2.0
"""sd beyond the corpus' range to which a fit may go; the penalty holds it back earlier."""
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
    penalty : ExponentialPenalty
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
    penalty: ExponentialPenalty
    neutral: FloatArray

    def points(self, alpha: FloatArray) -> FloatArray:
        """The model's points (N, 3), mm, head frame, at parameters (P,)."""
        modes = self.scene.modes[:, self.vertices]
        return np.asarray(self.scene.mean[self.vertices] + np.tensordot(alpha, modes, 1))

    def invert(self, points: FloatArray) -> FloatArray:
        """The direct inversion: parameters (..., P) of points (..., N, 3), mm, head frame."""
        return self.model.invert(self.frame.apply(points))

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
        ExponentialPenalty.of_corpus(built.alpha),
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


@dataclass(frozen=True, eq=False)
class TalkingFace:
    """A speaker-specific face: a shape and the four appearance models.

    Parameters
    ----------
    shape : FaceShape
    tex_lin, tex_cst : TextureModel
    la_lin, la_cst : LocalModel
        Their points are vertices of ``shape.outer``.
    la_scale : float
        Drawn pixels per image pixel at which local appearance was learned and is compared.
    """

    shape: FaceShape
    tex_lin: TextureModel
    tex_cst: TextureModel
    la_lin: LocalModel
    la_cst: LocalModel
    la_scale: float = 1.0

    def texture(self, name: str) -> TextureModel:
        """A texture model by its name.

        Raises
        ------
        ParameterError
            If there is no such model.
        """
        if name not in TEXTURES:
            raise ParameterError(
                f"there is no texture '{name}'", f"choose of {', '.join(TEXTURES)}"
            )
        return self.tex_lin if name == "tex_lin" else self.tex_cst

    def local(self, name: str) -> LocalModel:
        """A model of local appearance by its name.

        Raises
        ------
        ParameterError
            If there is no such model.
        """
        if name not in LOCALS:
            raise ParameterError(
                f"there is no local appearance '{name}'", f"choose of {', '.join(LOCALS)}"
            )
        return self.la_lin if name == "la_lin" else self.la_cst

    @cached_property
    def dressed(self) -> dict[str, Scene]:
        """S with each texture, made once for all frames."""
        return {name: self.texture(name).dress(self.shape.surface) for name in TEXTURES}


def sightings(shape: FaceShape, pictures: VisemePictures, alpha: FloatArray) -> list[Sighting]:
    """Pictures with the geometry that the articulatory model gives them.

    Parameters
    ----------
    shape : FaceShape
    pictures : VisemePictures
    alpha : (V, P) float64
        Parameters of the visemes.
    """
    return [
        Sighting(picture, shape.scene.vertices(row), pose, row)
        for picture, pose, row in zip(pictures.pictures, pictures.poses, alpha, strict=True)
    ]


def learn_face(
    shape: FaceShape,
    seen: Sequence[Sighting],
    camera: Camera,
    renderer: Renderer,
    *,
    count: int = N_POINTS,
) -> TalkingFace:
    """Learn the four appearance models from pictures of known geometry.

    Parameters
    ----------
    shape : FaceShape
    seen : sequence of Sighting
        Of ``shape.scene``; see `sightings`.
    camera : Camera
    renderer : Renderer
    count : int
        Points of local appearance; the paper's N is 63.

    Raises
    ------
    NothingSeenError
        If the pictures do not show the face.
    ParameterError
        If there are no pictures.
    """
    if not seen:
        raise ParameterError("there are no pictures to learn from", "give some")
    textured = shape.scene
    atlas = lay_atlas(textured, fitting_size(textured, camera, seen[0].pose), renderer)
    tex = learn_texture(seen, textured, atlas, camera, renderer)
    depth = float(seen[0].pose.apply(shape.pivot)[2])
    scale = min(1.0, FINEST * depth / float(camera.matrix[0, 0]))
    every = learn_local(seen, textured, shape.marks, camera, renderer, scale=scale)
    places = textured.mean[shape.marks].astype(np.float64)
    chosen = choose_points(every, count, places, SPACING, whiten=True)
    local = every.only(chosen).within(shape.kept)
    return TalkingFace(shape, tex, tex.constant(), local, local.constant(), scale)


def learned_from(face: TalkingFace, **models: TextureModel | LocalModel) -> TalkingFace:
    """The same face with other appearance models, such as ``tex_cst`` of a single picture."""
    return replace(face, **models)  # type: ignore[arg-type]
