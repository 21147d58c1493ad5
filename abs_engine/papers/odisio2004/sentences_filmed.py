"""Sentences of a bundled person, filmed by the studio, with what is true of each frame."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.dataset.codec import CLOSED_BELOW
from abs_engine.io.assets import Speaker
from abs_engine.papers.odisio2004.filmed import with_beads
from abs_engine.studio.appearance.look import Look
from abs_engine.studio.corpus.subtle import subtle
from abs_engine.studio.filming import plan_of
from abs_engine.studio.french import Sentence
from abs_engine.studio.people.lip_contact import widest_gap
from abs_engine.studio.plan import ClipPlan, Prop, View
from abs_engine.studio.sequence import Sequence, deform, expression, portrait, wander
from abs_engine.studio.speech import Utterance, articulate
from abs_engine.studio.take import Take

USUAL = Look()
RATE = 25.0
"""Frames per second."""


@dataclass(frozen=True, eq=False)
class Filmed:
    """A sentence as a camera saw it.

    Parameters
    ----------
    pictures : (T, H, W, 3) uint8 RGB
        Without compression.
    poses : tuple of Pose, T
        Head to camera.
    points : (T, N, 3) float64, mm, head frame
        Where the named points are.
    gaps : (T,) float64, mm
        Widest gap between the lips; see `abs_engine.studio.people.lip_contact.widest_gap`.
    """

    name: str
    text: str
    utterance: Utterance
    camera: Camera
    pictures: NDArray[np.uint8]
    poses: tuple[Pose, ...]
    points: FloatArray
    gaps: FloatArray

    def __len__(self) -> int:
        """Return the number of frames, T."""
        return len(self.pictures)

    @property
    def closed(self) -> BoolArray:
        """Frames (T,) in which the lips touch all along."""
        return np.asarray(self.gaps < CLOSED_BELOW)


def speak(speaker: Speaker, neutral: NDArray[np.floating], utterance: Utterance) -> FloatArray:
    """Face-unit weights (T, 52) of an utterance, jaw thrust and pressed cheeks among them."""
    weights = articulate(speaker, neutral, utterance, RATE).weights
    times = np.arange(len(weights)) / RATE
    more = subtle(utterance, times, speaker.unit_names)
    return np.asarray(np.clip(weights + more, 0.0, 1.0), np.float64)


def plan_sentence(
    speaker: Speaker,
    person: str,
    sentence: Sentence,
    camera: Camera,
    seed: int,
    beads: int = 0,
    look: Look = USUAL,
    reach: float = 1.0,
) -> ClipPlan:
    """A sentence before a camera: small head motion, blinks and brows; lamps, shading, noise.

    Parameters
    ----------
    camera : Camera
        The head is placed so that the face fills most of its picture's height.
    seed : int
        Of the head's motion, the blinks and the noise.
    beads : int
        On the face, as `filmed.film_visemes` has them.
    reach : float
        Factor of the head's motion; see `studio.sequence.wander`.

    Raises
    ------
    ParameterError
        If the camera cannot film it.
    """
    neutral, utterance = speaker.named(person), sentence.utterance
    rng = np.random.default_rng([seed, *map(ord, sentence.name)])
    weights = speak(speaker, neutral, utterance)
    times = np.arange(len(weights)) / RATE
    weights = weights + expression(times, speaker.unit_names, rng)
    rotations, shifts = wander(times, portrait(camera, speaker, neutral), rng, reach)
    act = Sequence(person, sentence.text, RATE, weights, rotations, shifts, ("",) * len(times))
    plan = plan_of(speaker, act, camera, look, int(rng.integers(2**31)))
    return with_beads(speaker, plan, beads)


def truth_of(
    speaker: Speaker, plan: ClipPlan, sentence: Sentence, vertices: NDArray[np.integer]
) -> Filmed:
    """Ground truth of each frame of a plan, with black pictures of a pixel; nothing is drawn."""
    heads = [plan.neutral + deform(speaker, row).astype(np.float32) for row in plan.weights]
    view = plan.views[0]
    return Filmed(
        sentence.name, sentence.text, sentence.utterance, view.camera,
        np.zeros((len(plan), 1, 1, 3), np.uint8),
        tuple(plan.pose(view, frame) for frame in range(len(plan))),
        np.array([head[vertices] for head in heads], np.float64),
        np.array([widest_gap(speaker, head) for head in heads]),
    )  # fmt: skip


def film_plan(
    speaker: Speaker, plan: ClipPlan, sentence: Sentence, vertices: NDArray[np.integer]
) -> Filmed:
    """Film a plan that says a sentence with its only camera, in memory; errors as `Take`.

    Vertices (N,) are those of the named points.
    """
    with Take(speaker, plan, 0, ()) as take:
        pictures = [shot.picture for _, shot in take.film(0, len(plan))]
    return replace(truth_of(speaker, plan, sentence, vertices), pictures=np.stack(pictures))


def cut(plan: ClipPlan, frames: int | None) -> ClipPlan:
    """The first frames of a plan, or all, what belongs to them cut alike."""
    if frames is None:
        return plan

    def first(value: ClipPlan | View | Prop, *names: str) -> dict[str, Any]:
        return {n: getattr(value, n)[:frames] for n in ("rotations", "translations", *names)}

    views = tuple(replace(v, **first(v, "gain", "blur")) for v in plan.views)
    props = tuple(replace(p, **first(p, "present")) for p in plan.props)
    own = first(plan, "weights", "phonemes", "lights")
    return replace(plan, **own, views=views, props=props)
