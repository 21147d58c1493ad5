"""Which targets change a person, and the people that come with the head."""

from __future__ import annotations

import numpy as np
from speaker_source import TARGETS, Source

ORIGINS = ("african", "asian", "caucasian")
MACROS = {
    f"{origin}-{sex}-{age}": weight / 6.0
    for origin in ORIGINS
    for sex in ("female", "male")
    for age, weight in (("young", 0.75), ("old", 0.25))
}
"""Macro targets and their weights in the average person; the weights sum to one."""

FOLDERS = ("mouth", "chin", "nose", "cheek", "head", "forehead", "eyebrows")
LEFT_OUT = (
    "trans-in",
    "trans-out",
    "head-trans",
    "head-angle",
    "septumangle",
    "nostrils-angle",
    "compression",
    "head-age",
    "nose-greek",
    "nose-width1",
    "nose-width2",
    "nose-flaring",
    "forehead-nubian",
    "forehead-temple",
    "forehead-trans",
    "head-back",
    "head-diamond",
    "head-triangular",
    "head-invertedtriangular",
    "mouth-dimples",
    "eyebrows-trans-for",
    "eyebrows-trans-back",
    "chin-cleft",
    "nose-trans",
    "cheek-trans",
    "nose-curve",
    "nose-base",
    "nose-width3",
)

PEOPLE: dict[str, dict[str, float]] = {
    "clara": {
        "macro/caucasian-female-young": 1.0,
        "mouth/mouth-upperlip-height-decr": 0.25,
        "head/head-oval": 0.4,
        "nose/nose-volume-decr": 0.3,
        "chin/chin-width-decr": 0.3,
    },
    "kofi": {
        "macro/african-male-young": 1.0,
        "mouth/mouth-lowerlip-volume-incr": 0.5,
        "mouth/mouth-upperlip-volume-incr": 0.5,
        "mouth/mouth-scale-horiz-incr": 0.2,
        "chin/chin-bones-incr": 0.3,
        "head/head-oval": 0.3,
    },
    "mei": {
        "macro/asian-female-young": 0.8,
        "macro/asian-female-old": 0.2,
        "head/head-round": 0.4,
        "mouth/mouth-scale-horiz-decr": 0.15,
        "mouth/mouth-upperlip-volume-decr": 0.3,
    },
    "walter": {
        "macro/caucasian-male-old": 0.75,
        "macro/caucasian-male-young": 0.25,
        "mouth/mouth-upperlip-height-decr": 0.35,
        "mouth/mouth-lowerlip-height-decr": 0.5,
        "mouth/mouth-upperlip-volume-decr": 0.35,
        "mouth/mouth-lowerlip-volume-decr": 0.4,
        "nose/nose-hump-incr": 0.4,
        "mouth/mouth-scale-horiz-incr": 0.2,
        "head/head-rectangular": 0.3,
    },
    "amara": {
        "macro/african-female-young": 0.9,
        "macro/african-female-old": 0.1,
        "mouth/mouth-lowerlip-volume-incr": 0.6,
        "mouth/mouth-upperlip-volume-incr": 0.7,
        "mouth/mouth-upperlip-height-incr": 0.3,
        "head/head-oval": 0.5,
    },
    "ravi": {
        "macro/caucasian-male-young": 0.55,
        "macro/asian-male-young": 0.2,
        "macro/african-male-young": 0.1,
        "macro/caucasian-male-old": 0.15,
        "nose/nose-hump-incr": 0.5,
        "head/head-fat-incr": 0.35,
        "mouth/mouth-scale-horiz-incr": 0.3,
    },
}


def identity_targets(source: Source) -> list[tuple[str, str]]:
    """List (name, file) of the targets that change a person, macro ones first."""
    macros = [("macro/" + name, TARGETS + f"macrodetails/{name}.target.gz") for name in MACROS]
    locals_ = []
    for folder in FOLDERS:
        for file in source.list(TARGETS + folder + "/", ".target.gz"):
            name = file.removeprefix(TARGETS).removesuffix(".target.gz")
            if not any(word in name for word in LEFT_OUT):
                locals_.append((name, file))
    return macros + locals_


def people_weights(names: list[str]) -> np.ndarray:
    """Return the (P, K) weights of the people over the named targets."""
    table = np.zeros((len(PEOPLE), len(names)), np.float32)
    for row, weights in enumerate(PEOPLE.values()):
        for name, value in weights.items():
            table[row, names.index(name)] = value
    return table
