"""A person who is filmed: a shape among the speaker's, and the look of the skin."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import ParameterError
from abs_engine.face.schema import MACRO
from abs_engine.io.assets import Speaker
from abs_engine.studio.people.tones import Colour

LARGEST_SET = 400
"""More dots than this cannot be told apart on a face."""

MOST_WEIGHT = 3.0
"""Targets are made for weights up to 1, or are components by which few people differ by more than
three standard deviations."""


@dataclass(frozen=True)
class Person:
    """A person who need not be one of those that come with the head.

    Parameters
    ----------
    base : str
        One of `speaker.people`: gives the texture that is painted over and, unless `identity`
        has a macro target, the shape that is started from.
    identity : mapping of str to float
        Weights of shape targets, named as `Speaker.identity_weights` takes them. They are added
        to the shape of `base`. A macro target among them (its name has the form
        ``asian_female_old``) replaces that shape: the person is then described by these weights
        alone.
    skin, lips, hair : tuple of int, optional
        sRGB, 0 to 255: medians over forehead, cheeks and nose, over the lips, over the hair.
        None keeps the colour of `base`, except that lips follow a given skin.
    stubble, freckles : float
        0 to 1, added to what `base` has.
    beads : int or str
        So many coloured beads spread over the face, or a set of dots by name (see `DOT_SETS`);
        0 paints none.
    seed : int
        Of freckles and stubble.

    Raises
    ------
    ParameterError
        If a value is outside of its range.
    """

    name: str
    base: str
    identity: Mapping[str, float] = field(default_factory=dict)
    skin: Colour | None = None
    lips: Colour | None = None
    hair: Colour | None = None
    stubble: float = 0.0
    freckles: float = 0.0
    beads: int | str = 0
    seed: int = 0

    def __post_init__(self) -> None:
        for part in ("skin", "lips", "hair"):
            colour = getattr(self, part)
            if colour is not None and (len(colour) != 3 or not all(0 <= c <= 255 for c in colour)):
                raise ParameterError(
                    f"{self.name}: the colour of {part} is {colour}",
                    "give red, green and blue, 0 to 255",
                )
        for part in ("stubble", "freckles"):
            if not 0 <= getattr(self, part) <= 1:
                raise ParameterError(
                    f"{self.name}: {part} is {getattr(self, part)}", "give a number from 0 to 1"
                )
        if not isinstance(self.beads, str) and not 0 <= self.beads <= LARGEST_SET:
            raise ParameterError(
                f"{self.name}: {self.beads} beads", f"give 0 to {LARGEST_SET} beads, or a set"
            )


def identity_vector(speaker: Speaker, person: Person) -> NDArray[np.float32]:
    """Weights (K,) float32 of the speaker's identity targets.

    Raises
    ------
    ParameterError
        If the base or a target is unknown, or a weight is beyond `MOST_WEIGHT`.
    """
    speaker_base(speaker, person)
    known = {n.split("/")[-1].replace("-", "_"): n for n in speaker.identity_names}
    for target, weight in person.identity.items():
        if target not in known:
            raise ParameterError(
                f"{person.name}: there is no shape target '{target}'",
                f"choose one of {', '.join(known)}",
            )
        if not abs(weight) <= MOST_WEIGHT:  # nor is NaN
            raise ParameterError(
                f"{person.name}: the weight of '{target}' is {weight}",
                f"give a number from {-MOST_WEIGHT:g} to {MOST_WEIGHT:g}",
            )
    own = speaker.identity_weights(**person.identity)
    replaced = any(known[target].startswith(MACRO) for target in person.identity)
    return own if replaced else np.asarray(own + speaker.people[person.base], np.float32)


def neutral(speaker: Speaker, person: Person) -> NDArray[np.float32]:
    """Vertices (V, 3) float32, mm, head frame, of the person at rest, mouth closed.

    Errors are those of `identity_vector`.
    """
    return speaker.person(identity_vector(speaker, person))


def speaker_base(speaker: Speaker, person: Person) -> str:
    """The name of the base.

    Raises
    ------
    ParameterError
        If the speaker has no such person.
    """
    if person.base not in speaker.people:
        raise ParameterError(
            f"{person.name}: there is no person '{person.base}' to start from",
            f"choose one of {', '.join(speaker.people)}",
        )
    return person.base
