"""Visemes by three-dimensional lips and by flat ones, seen from several sides.

Basu et al. (1998, section 7) hope that three-dimensional lips help to read speech. Here the studio
speaks random syllables by each bundled person, and visemes are classified by the lips: by their
true shape in the head's frame, noise added, and by its picture. A linear discriminant is learned
from all people but one and tested on that one. What it transmits is the mutual information of
visemes and answers (Miller and Nicely 1955), in bits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.io.assets import Speaker
from abs_engine.studio.speech import parse_phonemes
from abs_engine.studio.speech.articulate import articulate

VISEMES = ("p", "f", "t", "S", "w", "i", "e", "a", "o", "u")
"""Phonemes in X-SAMPA, each of which looks unlike the others."""
YAWS = (0, 15, 30, 45, 60)
"""Degrees by which heads are turned from the camera."""
NOISE_MM, NOISE_DEGREES = 0.5, 2.0
"""Of each coordinate of a point, and of the head's pose about each axis, which three-dimensional
lips need: about what tracked films show, here from every side alike, in their favour: a tracker's
errors grow with the yaw."""
_CONSONANTS, _VOWELS = VISEMES[:5], VISEMES[5:]
SYLLABLES = 300  # of each person
_RATE = 50.0
_NOSE = 30  # its tip, of the usual 68 landmarks
_LIPS = slice(48, 68)


@dataclass(frozen=True, eq=False)
class Spoken:
    """Lips of one person in the middle of each viseme.

    Parameters
    ----------
    lips : (N, 20, 3) float64, mm, head frame, from the tip of the nose
    rest : (20, 3) float64
        The same at rest.
    viseme : (N,) int64
        Index into `VISEMES`.
    """

    lips: FloatArray
    rest: FloatArray
    viseme: IntArray


def spoken(speaker: Speaker, person: str, rng: np.random.Generator, syllables: int) -> Spoken:
    """Random syllables of a person, a pause after each third."""
    said: list[str] = []
    for number in range(syllables):
        said += [rng.choice(_CONSONANTS), rng.choice(_VOWELS)] + ["_"] * (number % 3 == 2)
    neutral = speaker.named(person)
    utterance = parse_phonemes(" ".join(["_", *said, "_"]))
    speech = articulate(speaker, neutral, utterance, _RATE)
    segments = [s for s in utterance.segments if s.phoneme.label != "_"]
    frames = [min(round(s.middle * _RATE), len(speech) - 1) for s in segments]
    marks = speaker.points["landmark_68"]
    rest = neutral[marks].astype(np.float64)
    units = speaker.unit_matrix(speaker.unit_names)[:, marks].astype(np.float64)
    moved = rest + np.tensordot(speech.weights[frames], units, 1)
    viseme = np.array([VISEMES.index(v) for v in said if v != "_"])
    return Spoken(moved[:, _LIPS] - moved[:, [_NOSE]], rest[_LIPS] - rest[_NOSE], viseme)


def turned(points: FloatArray, yaw: float) -> FloatArray:
    """Points (..., 3) of a head that turns by some degrees, as a far camera shows them (..., 2)."""
    rotation = Rotation.from_euler("y", yaw, degrees=True).as_matrix()
    return np.asarray((points @ rotation.T)[..., :2])


def solid(one: Spoken, rng: np.random.Generator) -> FloatArray:
    """Lips (N, 60) as a tracker in three dimensions finds them, from whatever side."""
    turns = Rotation.from_rotvec(np.radians(NOISE_DEGREES) * rng.normal(size=(len(one.lips), 3)))
    return _noisy(np.einsum("nij,npj->npi", turns.as_matrix(), one.lips) - one.rest, rng)


def flat(one: Spoken, yaw: float, rest: float, rng: np.random.Generator) -> FloatArray:
    """Lips (N, 40) in the picture of a head that is turned, less those at rest seen from `rest`."""
    return _noisy(turned(one.lips, yaw) - turned(one.rest, rest), rng)


def _noisy(points: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Points (N, K, D), off by `NOISE_MM`, as features (N, K * D)."""
    off = NOISE_MM * rng.normal(size=points.shape)
    return np.asarray((points + off).reshape(len(points), -1), np.float64)


@dataclass(frozen=True, eq=False)
class Discriminant:
    """A linear discriminant: Gaussian classes (C, D) that share a covariance (Fisher 1936)."""

    means: FloatArray
    slopes: FloatArray

    @classmethod
    def of(cls, features: FloatArray, classes: IntArray) -> Discriminant:
        """Learned from features (N, D) of classes (N,), all equally frequent beforehand."""
        means = np.stack([features[classes == k].mean(axis=0) for k in range(classes.max() + 1)])
        left = features - means[classes]
        return cls(means, np.linalg.solve(left.T @ left / (len(left) - len(means)), means.T))

    def __call__(self, features: FloatArray) -> IntArray:
        """The most probable class (N,) of features (N, D)."""
        level = 0.5 * (self.means * self.slopes.T).sum(axis=1)
        return np.asarray(np.argmax(features @ self.slopes - level, axis=1), np.int64)


def transmitted(true: IntArray, answers: IntArray) -> float:
    """Mutual information of classes (N,) and answers (N,), bits, by their frequencies."""
    joint = np.zeros((true.max() + 1, answers.max() + 1))
    np.add.at(joint, (true, answers), 1 / len(true))
    alone = np.outer(joint.sum(axis=1), joint.sum(axis=0))
    some = joint > 0
    return float((joint[some] * np.log2(joint[some] / alone[some])).sum())


Seen = Callable[[Spoken, float], FloatArray]
"""Features (N, D) of lips at a yaw in degrees."""


def scores(
    people: Sequence[Spoken], seen: Seen, learned: Seen | None = None
) -> dict[str, list[float]]:
    """Error rates and transmitted bits at each of `YAWS`, each person left out in turn.

    A discriminant of what is `learned` at a yaw, by default what is seen, is tested on what is
    `seen` at it.
    """
    learned = learned or seen
    truth = np.concatenate([one.viseme for one in people])
    error, bits = [], []
    for yaw in YAWS:
        answers = []
        for out, one in enumerate(people):
            rest = [other for k, other in enumerate(people) if k != out]
            features = np.concatenate([learned(other, yaw) for other in rest])
            rule = Discriminant.of(features, np.concatenate([other.viseme for other in rest]))
            answers.append(rule(seen(one, yaw)))
        given = np.concatenate(answers)
        error.append(float((given != truth).mean()))
        bits.append(transmitted(truth, given))
    return {"error_rate": error, "bits": bits}


def viseme_information(speaker: Speaker, seed: int, syllables: int = SYLLABLES) -> dict[str, Any]:
    """Bits and error rate of visemes against the head's yaw, by solid lips and by flat ones.

    Returns
    -------
    dict
        `yaws`, degrees; `visemes`; `samples`; `bits_at_most`, the visemes' entropy; and for
        `solid` lips, `flat` ones learned from the front and `flat_each_yaw`, learned at the yaw
        at which they are tested, `error_rate` and `bits`, one for each yaw.
    """
    rng = np.random.default_rng(seed)
    people = [spoken(speaker, name, rng, syllables) for name in speaker.people]
    truth = np.concatenate([one.viseme for one in people])

    return {
        "yaws": list(YAWS), "visemes": list(VISEMES), "samples": len(truth),
        "bits_at_most": transmitted(truth, truth),
        "solid": scores(people, lambda one, _: solid(one, rng)),
        "flat": scores(
            people, lambda one, yaw: flat(one, yaw, 0, rng), lambda one, _: flat(one, 0, 0, rng)
        ),
        "flat_each_yaw": scores(people, lambda one, yaw: flat(one, yaw, yaw, rng)),
    }  # fmt: skip
