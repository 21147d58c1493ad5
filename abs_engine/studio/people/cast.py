"""Draws people by chance who look like people."""

from __future__ import annotations

import numpy as np

from abs_engine.core.errors import ParameterError
from abs_engine.dataset.codec import CLOSED_BELOW
from abs_engine.io.assets import Speaker
from abs_engine.studio.people.lip_contact import widest_gap
from abs_engine.studio.people.person import Person, neutral
from abs_engine.studio.people.tones import Colour, tone_at

SPREAD = {
    "mouth_scale_horiz": 0.20, "mouth_upperlip_height": 0.22, "mouth_lowerlip_height": 0.22,
    "mouth_upperlip_volume": 0.25, "mouth_lowerlip_volume": 0.25, "mouth_cupidsbow": 0.30,
    "chin_bones": 0.22, "chin_height": 0.16, "chin_width": 0.22, "chin_prominent": 0.22,
    "chin_jaw_drop": 0.25, "chin_prognathism": 0.14,
    "nose_hump": 0.28, "nose_nostrils_width": 0.22, "nose_point_width": 0.3,
    "nose_scale_depth": 0.16, "nose_scale_horiz": 0.25, "nose_scale_vert": 0.20,
    "nose_volume": 0.22,
    "cheek_bones": 0.28, "cheek_inner": 0.25, "cheek_volume": 0.20,
    "head_fat": 0.20, "head_scale_depth": 0.13, "head_scale_horiz": 0.10,
    "head_scale_vert": 0.08, "forehead_scale_vert": 0.10,
}  # fmt: skip
"""Standard deviation of the weight of each pair of targets; drawn weights stay within two.

A weight below zero is one of the target ``..._decr``, above zero of ``..._incr``.
"""
_SHAPES = ("head_oval", "head_rectangular", "head_round", "head_square", "chin_triangle")
_ORIGINS = ("african", "asian", "caucasian")
_TONE = {"african": 0.80, "asian": 0.40, "caucasian": 0.28}
_BASES = {
    ("african", "female"): "amara", ("african", "male"): "kofi", ("asian", "female"): "mei",
    ("asian", "male"): "ravi", ("caucasian", "female"): "clara", ("caucasian", "male"): "ravi",
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
    speaker : Speaker
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
    origin = _ORIGINS[rng.integers(3)]
    sex = ("female", "male")[rng.integers(2)]
    age = float(rng.beta(1.2, 2.2))
    tone = float(np.clip(_TONE[origin] + rng.normal(0, 0.13), 0.04, 1))
    old = age > 0.55 and sex == "male" and tone < 0.6
    seed = int(rng.integers(1_000_000))
    return Person(
        name=name or f"person-{seed:06d}",
        base="walter" if old else _BASES[origin, sex],
        identity=_shape(rng, origin, sex, age),
        skin=tone_at(tone),
        hair=None if old else _hair(rng, tone, age),
        stubble=float(rng.choice([0.0, 0.0, 0.3, 0.6])) if sex == "male" else 0.0,
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
    shares = {o: 0.25 * s for o, s in zip(_ORIGINS, rng.dirichlet([1, 1, 1]), strict=True)}
    shares[origin] += 0.75
    typical = float(rng.uniform(0.8, 1.0))
    other = "male" if sex == "female" else "female"
    weights = {
        f"{o}_{s}_{when}": float(share * of_sex * of_age)
        for o, share in shares.items()
        for s, of_sex in ((sex, typical), (other, 1 - typical))
        for when, of_age in (("young", 1 - age), ("old", age))
    }
    weights[_SHAPES[rng.integers(len(_SHAPES))]] = float(rng.uniform(0, 0.45))
    for pair, spread in SPREAD.items():
        value = spread * float(np.clip(rng.normal(), -2, 2))
        end = "incr" if value > 0 else "decr"
        sides = ("l_", "r_") if pair.startswith("cheek") else ("",)
        weights |= {f"{side}{pair}_{end}": abs(value) for side in sides}
    return weights
