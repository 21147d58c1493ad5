"""Sequences of visemes that a person says, and one of them filmed with one camera."""

from __future__ import annotations

import numpy as np

from abs_engine.dataset.codec import CLOSED_BELOW, LABELS
from abs_engine.studio.appearance.look import Look
from abs_engine.studio.filming import plan_of
from abs_engine.studio.make import Crew, Order, make
from abs_engine.studio.people.lip_contact import widest_gap
from abs_engine.studio.sequence import Sequence, deform, expression, portrait, utter, wander
from abs_engine.studio.speech.lips import Lips

OPTIONAL = tuple(label for label in LABELS if label not in ("ids", "depth"))


def say(text, speaker, person, camera, *, rate=25.0, frames=None, seed=0):
    """A sentence, small head motion, blinks and brows before a camera."""
    rng = np.random.default_rng(seed)
    neutral = speaker.named(person)
    talk = utter(text, speaker, neutral, rate, frames)
    times = np.arange(len(talk.weights)) / rate
    weights = talk.weights + expression(times, speaker.unit_names, rng)
    rotations, translations = wander(times, portrait(camera, speaker, neutral), rng)
    return Sequence(
        person, text, rate, weights, rotations, translations, talk.phonemes, talk.intervals
    )


def closed_in(speaker, sequence):
    """Frames (T,) in which the lips of the mesh touch all along."""
    neutral = speaker.named(sequence.person)
    gaps = [widest_gap(speaker, neutral + deform(speaker, row)) for row in sequence.weights]
    return np.array(gaps) < CLOSED_BELOW


def film(
    speaker, sequence, camera, folder, *,
    seed=0, lossless=False, labels=OPTIONAL, command="", progress=None,
):  # fmt: skip
    """The data set of one sequence."""
    plan = plan_of(speaker, sequence, camera, Look(), seed, command)
    crew = Crew(processes=1, filming=progress)
    return make([plan], 1, folder, speaker, Order(command, seed, labels, lossless), crew).folder


def tooth_gap(speaker, vertices):
    """Distance, mm, of the lower lip from the upper front teeth: the median along their edge."""
    gaps, _ = Lips.of(speaker, vertices).tooth_gaps(np.zeros(len(speaker.unit_names)))
    return float(np.median(gaps))
