"""Draws people by chance who look like people."""

from __future__ import annotations

import numpy as np

from abs_engine.core.errors import ParameterError
from abs_engine.dataset.codec import CLOSED_BELOW
from abs_engine.face.schema import (
    AFRICAN,
    ASIAN,
    CAUCASIAN,
    DRAWN_TARGETS,
    FEMALE,
    FORMS,
    MALE,
    ORIGINS,
    SEXES,
    drawn_targets,
    macro_targets,
)
from abs_engine.io.assets import Speaker
from abs_engine.studio.people.lip_contact import widest_gap
from abs_engine.studio.people.person import Person, neutral
from abs_engine.studio.people.tones import Colour, tone_at

_TONE = {AFRICAN: 0.80, ASIAN: 0.40, CAUCASIAN: 0.28}
_BASES = {
    (AFRICAN, FEMALE): "amara", (AFRICAN, MALE): "kofi", (ASIAN, FEMALE): "mei",
    (ASIAN, MALE): "ravi", (CAUCASIAN, FEMALE): "clara", (CAUCASIAN, MALE): "ravi",
}  # fmt: skip
_HAIR: tuple[Colour, ...] = ((26, 22, 21), (34, 27, 24), (58, 40, 30), (92, 62, 42), (140, 104, 66))
_GREY: Colour = (140, 134, 128)
_ATTEMPTS = 20


def random_person(speaker: Speaker, rng: np.random.Generator, name: str = "") -> Person:
    """Draw a person: origin, sex, age, the form of the face, tone of the skin, hair and marks.

    The draw takes whom the shape targets can make, not a population: it says nothing on how often
    a face or a tone is met.

    Parameters
    ----------
    rng : numpy.random.Generator
        The same state gives the same person.
    name : str, optional
        By default ``person-`` and a number that is drawn.

    Raises
    ------
    ParameterError
        If the speaker lacks the targets or textures, or no face with closed lips is found.
    """
    for _ in range(_ATTEMPTS):
        person = _draw(rng, name)
        if widest_gap(speaker, neutral(speaker, person)) < CLOSED_BELOW:
            return person
    raise ParameterError("no random face of this speaker closes its lips", "use the bundled head")


def _draw(rng: np.random.Generator, name: str) -> Person:
    origin = ORIGINS[rng.integers(3)]
    sex = SEXES[rng.integers(2)]
    age = float(rng.beta(1.2, 2.2))
    tone = float(np.clip(_TONE[origin] + rng.normal(0, 0.13), 0.04, 1))
    old = age > 0.55 and sex == MALE and tone < 0.6
    seed = int(rng.integers(1_000_000))
    return Person(
        name=name or f"person-{seed:06d}",
        base="walter" if old else _BASES[origin, sex],
        identity=_shape(rng, origin, sex, age),
        skin=tone_at(tone),
        hair=None if old else _hair(rng, tone, age),
        stubble=float(rng.choice([0.0, 0.0, 0.3, 0.6])) if sex == MALE else 0.0,
        freckles=float(rng.choice([0.0, 0.5, 0.9])) if tone < 0.3 else 0.0,
        seed=seed,
    )


def _hair(rng: np.random.Generator, tone: float, age: float) -> Colour:
    darkest = 5 if tone < 0.3 else 2
    own = np.array(_HAIR[rng.integers(darkest)], float)
    grey = float(np.clip((age - 0.45) / 0.4, 0, 1))
    red, green, blue = (int(v) for v in np.rint(own + grey * (np.array(_GREY) - own)))
    return red, green, blue


def _shape(rng: np.random.Generator, origin: str, sex: str, age: float) -> dict[str, float]:
    """Weights of the targets; those of the macro targets sum to one."""
    shares = {o: 0.25 * s for o, s in zip(ORIGINS, rng.dirichlet([1, 1, 1]), strict=True)}
    shares[origin] += 0.75
    typical = float(rng.uniform(0.8, 1.0))
    other = MALE if sex == FEMALE else FEMALE
    weights = {
        target: float(share * of_sex * of_age)
        for o, share in shares.items()
        for s, of_sex in ((sex, typical), (other, 1 - typical))
        for target, of_age in macro_targets(o, s, age).items()
    }
    weights[FORMS[rng.integers(len(FORMS))]] = float(rng.uniform(0, 0.45))
    for pair, spread in DRAWN_TARGETS.items():
        weights |= drawn_targets(pair, spread * float(np.clip(rng.normal(), -2, 2)))
    return weights
