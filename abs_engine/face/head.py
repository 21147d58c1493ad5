"""The head as the tracker uses it: what moves, what is drawn, which points are reported."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.errors import ModelFormatError
from abs_engine.core.params import ParamSpec
from abs_engine.core.pose import mode_block
from abs_engine.core.scene import Scene
from abs_engine.face.base import lip_aperture
from abs_engine.face.mouth_fields import mouth_fields
from abs_engine.face.rings import rings_of
from abs_engine.face.schema import PERSON_TARGETS, Pair, Unit, by_unit
from abs_engine.face.settings.shape import SHAPE
from abs_engine.face.shape.linear import LinearShape
from abs_engine.face.shape.mouth import mouth_shape, mouth_units
from abs_engine.io.assets import Speaker

_POSTURES: tuple[dict[str, float], ...] = (
    {},
    {Pair.MOUTH_PRESS: 0.3, Unit.JAW_OPEN: 0.03},
    {Unit.JAW_OPEN: 0.08},
    {Unit.JAW_OPEN: 0.2, Pair.MOUTH_UPPER_UP: 0.2},
    {Unit.JAW_OPEN: 0.35},
    {Unit.JAW_OPEN: 0.15, Unit.MOUTH_FUNNEL: 0.4, Unit.MOUTH_PUCKER: 0.5},
    {Unit.JAW_OPEN: 0.12, Pair.MOUTH_STRETCH: 0.4},
    {Unit.MOUTH_ROLL_LOWER: 0.6, Pair.MOUTH_UPPER_UP: 0.3, Unit.JAW_OPEN: 0.08},
)
PROTOTYPES = tuple(map(by_unit, _POSTURES))
"""Postures that a fit is started from, in weights of face units."""


# Facet classes by the colour class that they show; others are not compared
COLOUR_CLASSES: dict[str, tuple[str, ...]] = {
    "skin": ("skin",),
    "lips": ("upper_lip", "lower_lip"),
    "teeth": ("upper_teeth", "lower_teeth"),
    "dark": ("inner_mouth", "tongue"),
}
IN_OPEN_MOUTH = (*COLOUR_CLASSES["teeth"], *COLOUR_CLASSES["dark"])  # what it shows


@dataclass(frozen=True, eq=False)
class MouthModel:
    """The lower face for fitting and the whole head for pose.

    Parameters
    ----------
    speaker : Speaker
    expression : LinearShape
        Modes of the whole head; P of them.
    head : Scene
        The whole head, neutral, without modes.
    scene : Scene
        The lower face with P expression modes, then Q person modes.
    kept : (V',) int32
        Vertex of the head for each vertex of `scene`.
    rigid : (F,) bool
        Facets of `head` that move with the skull and are good to follow.
    prototypes : (K, P) float64
        Expression parameters of the starting postures.
    pivot : (3,) float64, mm, head frame
    rings : mapping of str to int32 arrays
        Indices into `scene`'s vertices of `outer`, `upper`, `lower` (inner contours), `points`
        (12 outer and 8 inner), `corners`, and `jaw`, the lower teeth.
    person_spread : float
        How far the person's mouth may differ from this head's, as a share of how far people do:
        less than 1 where the head is fitted to the person already.
    """

    speaker: Speaker
    expression: LinearShape
    head: Scene
    scene: Scene
    kept: NDArray[np.int32]
    rigid: BoolArray
    prototypes: FloatArray
    pivot: FloatArray
    rings: Mapping[str, NDArray[np.int32]]
    person_spread: float = 1.0

    @property
    def n_expression(self) -> int:
        """Number of expression modes, P."""
        return len(self.expression.modes)

    @property
    def posture(self) -> ParamSpec:
        """Names, units, first steps and bounds of the weights of the expression modes."""
        return mode_block(self.n_expression, SHAPE.mode_limit)

    @property
    def n_person(self) -> int:
        """Number of person modes, Q."""
        return self.scene.n_modes - self.n_expression

    @property
    def known(self) -> bool:
        """Whether this is a known person's own head, with nothing of the person left to fit."""
        return self.n_person == 0

    @property
    def person_deviation(self) -> FloatArray:
        """Standard deviations of the person modes, (Q,)."""
        spread = [PERSON_TARGETS[n][2] for n in list(PERSON_TARGETS)[: self.n_person]]
        return self.person_spread * np.array(spread)

    @property
    def colour_classes(self) -> tuple[str | None, ...]:
        """Colour class of each facet class."""
        return colour_classes(self.speaker)

    def person(self, deviations: Mapping[str, float]) -> FloatArray:
        """Weights (Q,) of a person that differs from the average by these standard deviations.

        They are named as in `PERSON_TARGETS`; where nothing of the person is fitted, none counts.
        """
        names = list(PERSON_TARGETS)[: self.n_person]
        return np.array([deviations.get(n, 0.0) * PERSON_TARGETS[n][2] for n in names])

    def aperture(self, person: FloatArray, posture: FloatArray) -> float:
        """Height, mm, between the inner lips' middles of a person (Q,) in a posture (P,), or 0."""
        return lip_aperture(self.held(person).vertices(posture)[self.rings["points"]])

    def border(self, person: FloatArray | None = None) -> FloatArray:
        """The lips' outer contour (R, 3), mm, head frame, of a person (Q,) at rest."""
        at = self.head.mean[self.speaker.lip_ring].astype(np.float64)
        if person is None or not len(person):
            return at
        modes = self.scene.modes[self.n_expression :, self.rings["outer"]]
        return np.asarray(at + np.tensordot(person, modes, 1), np.float64)

    @cached_property
    def person_modes(self) -> NDArray[np.float32]:
        """The person modes over the whole head, (Q, V, 3), mm."""
        return _person_modes(self.speaker)[: self.n_person]

    def whole(self, person: FloatArray) -> NDArray[np.float32]:
        """The whole head (V, 3), mm, of a person (Q,) in posture 0, the average of speech."""
        return np.asarray(self.expression.mean + self._own(person), np.float32)

    def at_rest(self, person: FloatArray) -> NDArray[np.float32]:
        """The whole head (V, 3), mm, of a person (Q,) without expression."""
        return np.asarray(self.head.mean + self._own(person), np.float32)

    def _own(self, person: FloatArray) -> NDArray[np.float64]:
        """Differences of a person (Q,) from the average, (V, 3) mm."""
        return np.asarray(np.tensordot(person, self.person_modes, 1))

    def held(self, person: FloatArray) -> Scene:
        """The scene with the person modes fixed at `person` (Q,): P modes remain."""
        key = person.tobytes()
        if key not in self._held:
            self._held.clear()  # a person is asked for again and again, then another
            self._held[key] = self._fixed(person)
        return self._held[key]

    @cached_property
    def _held(self) -> dict[bytes, Scene]:
        return {}

    def _fixed(self, person: FloatArray) -> Scene:
        p, s = self.n_expression, self.scene
        moved = np.tensordot(person, s.modes[p:], 1)
        return Scene(
            s.mean + moved.astype(np.float32), s.modes[:p], s.faces, s.uv, s.facet_class, s.texture
        )


def colour_classes(speaker: Speaker) -> tuple[str | None, ...]:
    """Colour class that the facets of each facet class show; None is not compared.

    Raises `ModelFormatError` if the speaker lacks one of the facet classes.
    """
    shows = {name: colour for colour, names in COLOUR_CLASSES.items() for name in names}
    missing = [name for name in shows if name not in speaker.class_names]
    if missing:
        raise ModelFormatError(
            f"the speaker has no facet class {', '.join(missing)}",
            "name its classes as the bundled speaker does",
        )
    return tuple(shows.get(name) for name in speaker.class_names)


def build_mouth_model(
    speaker: Speaker,
    neutral: NDArray[np.float32],
    texture: NDArray[np.uint8],
    free_person: bool = True,
    expression: LinearShape | None = None,
    person_spread: float = 1.0,
) -> MouthModel:
    """Build the model for a person's neutral head (V, 3), mm: the average one, or a known person's.

    Parameters
    ----------
    texture : (H, W, 3) uint8 RGB
    free_person : bool
        Whether the person's mouth is to be fitted; False for a known person.
    expression : LinearShape, optional
        How this head's mouth moves; by default `mouth_shape`, by the units of `mouth_units`.
    person_spread : float
        See `MouthModel`.

    Raises
    ------
    ModelFormatError
        If the speaker lacks a facet class, or its landmarks are not on its mouth.
    """
    if expression is None:
        expression = mouth_shape(speaker, neutral, SHAPE.expression_modes)
    person = _person_modes(speaker) if free_person else np.zeros((0, *neutral.shape), np.float32)
    none = np.zeros((0, *neutral.shape), np.float32)
    classes = speaker.facet_class.astype(np.int32)
    head = Scene(neutral, none, speaker.faces, speaker.uv, classes, texture)
    mouth = neutral[speaker.lip_ring].mean(axis=0)
    facets = mouth_facets(speaker, neutral)
    kept, faces = np.unique(speaker.faces[facets], return_inverse=True)
    modes = np.concatenate([expression.modes, person])[:, kept]
    scene = Scene(
        expression.mean[kept], modes, faces.reshape(-1, 3).astype(np.int32), speaker.uv[kept],
        classes[facets], texture,
    )  # fmt: skip
    return MouthModel(
        speaker, expression, head, scene, kept.astype(np.int32), _rigid_facets(speaker, neutral),
        _prototypes(speaker, neutral, expression), mouth.astype(np.float64),
        rings_of(speaker, kept), person_spread,
    )  # fmt: skip


def mouth_facets(speaker: Speaker, neutral: NDArray[np.float32]) -> BoolArray:
    """Facets (F,) of a head (V, 3), mm, that a mouth model draws: near the lips, or inside."""
    mouth = neutral[speaker.lip_ring].mean(axis=0)
    near = np.linalg.norm(neutral - mouth, axis=1) < SHAPE.reach
    # without the inside an open mouth shows a hole
    return np.asarray(near[speaker.faces].all(axis=1) | _inside(speaker))


def _inside(speaker: Speaker) -> BoolArray:
    """Facets (F,) that an open mouth shows."""
    ids = [k for k, name in enumerate(speaker.class_names) if name in IN_OPEN_MOUTH]
    return np.isin(speaker.facet_class, ids)


def _person_modes(speaker: Speaker) -> NDArray[np.float32]:
    if speaker.imported:
        return mouth_fields(speaker)
    modes = []
    for less, more, _ in PERSON_TARGETS.values():
        pair = speaker.identity_weights(**{less: -0.5}) + speaker.identity_weights(**{more: 0.5})
        used = np.flatnonzero(pair)
        modes.append(np.tensordot(pair[used], speaker.identity[used].astype(np.float32), 1))
    return np.asarray(modes, np.float32)


def _rigid_facets(speaker: Speaker, neutral: NDArray[np.float32]) -> BoolArray:
    """Skin from below the nose to the brow, to the front; neither eyes nor what speech moves."""
    centre = neutral[speaker.faces].mean(axis=1)
    nose = neutral[speaker.landmarks["nose_tip"][0]]
    eyes = neutral[speaker.landmarks["eye_corners"]]
    height = (centre[:, 1] > nose[1] - SHAPE.still_below) & (
        centre[:, 1] < eyes[:, 1].mean() + SHAPE.still_above
    )
    front = centre[:, 2] > eyes[:, 2].min() - SHAPE.still_behind
    return np.asarray(speaker.facets_of("skin") & height & front)


def _prototypes(
    speaker: Speaker, neutral: NDArray[np.float32], expression: LinearShape
) -> FloatArray:
    """Least-squares expression parameters of `PROTOTYPES` over the lips."""
    names = mouth_units()
    red = [k for k, colour in enumerate(colour_classes(speaker)) if colour == "lips"]
    lips = np.unique(speaker.faces[np.isin(speaker.facet_class, red)])
    matrix = expression.modes[:, lips].reshape(len(expression.modes), -1).T.astype(np.float64)
    units = speaker.unit_matrix(names)[:, lips]
    out = []
    for posture in PROTOTYPES:
        weights = np.array([posture.get(n, 0.0) for n in names])
        target = neutral[lips] + np.tensordot(weights, units, 1) - expression.mean[lips]
        out.append(np.linalg.lstsq(matrix, target.ravel(), rcond=None)[0])
    return np.asarray(
        np.clip(np.array(out), -SHAPE.prototype_limit, SHAPE.prototype_limit), np.float64
    )
