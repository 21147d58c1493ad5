"""Visemes as weights of the 52 face units, and a few sentences made of them."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import ParameterError
from abs_engine.face.schema import Pair, Unit, by_unit


@dataclass(frozen=True)
class Viseme:
    """A posture of the mouth and how long it is held.

    Parameters
    ----------
    units : mapping of str to float
        Weights of face units; a `Pair` stands for both of its own.
    seconds : float
        From the middle of the movement into it to the middle of the one out of it.
    hold : float
        Seconds, within `seconds`, in which the mouth stands still.
    """

    name: str
    units: Mapping[str, float] = field(default_factory=dict)
    seconds: float = 0.16
    hold: float = 0.04

    def weights(self, unit_names: tuple[str, ...]) -> NDArray[np.float64]:
        """Weights (N,) in the order of `unit_names`."""
        out = np.zeros(len(unit_names))
        for unit, value in by_unit(self.units).items():
            out[unit_names.index(unit)] = value
        return out


_JAW, _PRESS, _SMILE = Unit.JAW_OPEN, Pair.MOUTH_PRESS, Pair.MOUTH_SMILE
_STRETCH, _UPPER, _LOWER = Pair.MOUTH_STRETCH, Pair.MOUTH_UPPER_UP, Pair.MOUTH_LOWER_DOWN
_PUCKER, _FUNNEL = Unit.MOUTH_PUCKER, Unit.MOUTH_FUNNEL
_ROLL_LOWER, _ROLL_UPPER = Unit.MOUTH_ROLL_LOWER, Unit.MOUTH_ROLL_UPPER

# A little jawOpen goes with units that would press one lip into the other (see PROVENANCE.md).
VISEMES: dict[str, Viseme] = {
    v.name: v
    for v in (
        Viseme("rest", {}, 0.24, 0.12),
        Viseme("p", {_PRESS: 0.30, _PUCKER: 0.15, _JAW: 0.01}, 0.15, 0.09),
        Viseme("m", {_ROLL_LOWER: 0.15, _ROLL_UPPER: 0.15, _PUCKER: 0.1}, 0.16, 0.10),
        Viseme("f", {_JAW: 0.07, _ROLL_LOWER: 0.65, _UPPER: 0.30}, 0.16, 0.06),
        Viseme("a", {_JAW: 0.58, _LOWER: 0.20, _UPPER: 0.10}, 0.24, 0.06),
        Viseme("e", {_JAW: 0.28, _STRETCH: 0.30, _SMILE: 0.20, _LOWER: 0.10}, 0.20),
        Viseme("i", {_JAW: 0.13, _STRETCH: 0.35, _SMILE: 0.45, _LOWER: 0.35}, 0.20),
        Viseme("o", {_JAW: 0.30, _FUNNEL: 0.50, _PUCKER: 0.35}, 0.22, 0.06),
        Viseme("u", {_JAW: 0.13, _PUCKER: 0.70, _FUNNEL: 0.15}, 0.22, 0.06),
        Viseme("w", {_JAW: 0.165, _PUCKER: 0.85}, 0.16, 0.04),
        Viseme("s", {_JAW: 0.06, _STRETCH: 0.20, _LOWER: 0.30, _UPPER: 0.20}, 0.14),
        Viseme("l", {_JAW: 0.20, _LOWER: 0.15, _STRETCH: 0.10}, 0.14),
        Viseme("sh", {_JAW: 0.10, _FUNNEL: 0.50, _UPPER: 0.20, _LOWER: 0.2}, 0.16),
        Viseme("x", {_JAW: 0.16, _LOWER: 0.10}, 0.12),
    )
}
"""By name; 'x' is the vowel of 'the'."""

ALIASES: dict[str, str] = {
    **dict.fromkeys(("_", "."), "rest"),
    "b": "p",
    "v": "f",
    **dict.fromkeys(("t", "d", "z", "k", "g"), "s"),
    **dict.fromkeys(("n", "r", "th", "y"), "l"),
    **dict.fromkeys(("ch", "j"), "sh"),
    "h": "x",
}
"""Other names of the same posture."""

SENTENCES: dict[str, str] = {
    "demo": "_ m a p i w o f e b u _",
    "wolves": "_ b o b _ m e t x f u _ w u l v z _ b a i th x p u l _",
    "vowels": "_ a e i o u _ a u i o e a _",
    "closures": "_ m a m a _ p o p _ b i b _ p a p x m u m _",
}
"""Built-in sentences, as strings of visemes. 'wolves': 'Bob met a few wolves by the pool'."""


def parse(text: str) -> tuple[Viseme, ...]:
    """Visemes of a built-in sentence (by its name) or of a string of symbols between spaces.

    Raises
    ------
    ParameterError
        If the text is empty or a symbol is unknown; the nearest one is named.
    """
    symbols = SENTENCES.get(text.strip(), text).split()
    if not symbols:
        raise ParameterError("the sentence is empty", f"name one of {', '.join(SENTENCES)}")
    return tuple(_viseme(symbol) for symbol in symbols)


def _viseme(symbol: str) -> Viseme:
    name = ALIASES.get(symbol, symbol)
    if name in VISEMES:
        return VISEMES[name]
    known = [*VISEMES, *ALIASES, *SENTENCES]
    near = difflib.get_close_matches(symbol.lower(), known, n=1, cutoff=0.0)[0]
    raise ParameterError(
        f"there is no viseme '{symbol}' (nearest: '{near}')",
        f"write symbols between spaces out of {' '.join([*VISEMES, *ALIASES])}, "
        f"or a sentence's name: {', '.join(SENTENCES)}",
    )
