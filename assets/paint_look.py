"""Colours and marks of the people."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Look:
    """Colours (sRGB, 0 to 255) and amounts (0 to 1) that make up one person's texture.

    Attributes
    ----------
    skin, lip, iris, hair : tuple of int
    flush : float
        Redness of cheeks, nose and ears.
    freckles, stubble, age : float
    bald : float
        How far the hairline has receded, mm.
    brow : float
        Thickness of the brows, mm.
    lashes : float
        Darkness of the lid margins.
    """

    skin: tuple[int, int, int]
    lip: tuple[int, int, int]
    iris: tuple[int, int, int]
    hair: tuple[int, int, int]
    flush: float = 0.5
    freckles: float = 0.0
    stubble: float = 0.0
    age: float = 0.2
    bald: float = 0.0
    brow: float = 4.0
    lashes: float = 0.6


LOOKS = {
    "clara": Look(
        (229, 186, 163),
        (190, 106, 104),
        (96, 122, 132),
        (112, 72, 46),
        flush=0.8,
        freckles=0.7,
        brow=3.0,
        lashes=0.75,
    ),
    "kofi": Look(
        (108, 72, 52),
        (118, 66, 60),
        (52, 32, 22),
        (24, 20, 19),
        flush=0.35,
        stubble=0.55,
        brow=4.6,
        lashes=0.6,
    ),
    "mei": Look(
        (222, 180, 147),
        (188, 102, 98),
        (58, 38, 26),
        (28, 24, 24),
        flush=0.55,
        age=0.3,
        brow=3.2,
        lashes=0.7,
    ),
    "walter": Look(
        (212, 160, 136),
        (176, 108, 100),
        (98, 120, 110),
        (140, 134, 128),
        flush=0.7,
        stubble=0.4,
        age=1.0,
        bald=14.0,
        brow=4.6,
        lashes=0.35,
    ),
    "amara": Look(
        (146, 98, 70), (152, 80, 76), (56, 34, 24), (26, 20, 18), flush=0.4, brow=3.2, lashes=0.75
    ),
    "ravi": Look(
        (180, 130, 98),
        (152, 88, 80),
        (64, 42, 28),
        (30, 25, 23),
        flush=0.5,
        stubble=0.75,
        brow=4.6,
        lashes=0.6,
    ),
}
