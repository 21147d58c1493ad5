"""Paints a person's texture over one of those that come with the head.

Colours are changed by factors, so what varies over the skin (pores, blood, creases) keeps its
contrast: the logarithm of a texel moves by the logarithm of target over source, mixed by how much
of the texel is skin, lip and hair.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from abs_engine.core.arrays import Float32Array
from abs_engine.io.assets import Speaker
from abs_engine.studio.people import regions
from abs_engine.studio.people.chart import Chart, chart_of
from abs_engine.studio.people.dots import add_dots
from abs_engine.studio.people.person import Person, speaker_base
from abs_engine.studio.people.tones import lip_colour

_PIGMENT = np.array([0.50, 0.74, 1.02], np.float32)
"""How much more of green and blue than of red a freckle takes away."""
_HAIRS, _FRECKLES = 9000, ((0.5, 0.36, 230), (0.75, 0.30, 160), (1.05, 0.25, 100))
"""Freckles: radius in mm, strength, number."""


def paint(speaker: Speaker, person: Person) -> NDArray[np.uint8]:
    """The texture (H, W, 3) of a person, sRGB in the speaker's chart; the same each time.

    Raises
    ------
    ParameterError
        If the base, or a set of dots, is unknown.
    """
    source = speaker.texture(speaker_base(speaker, person))
    if not _changes(person):
        return source
    chart = chart_of(speaker, source.shape[0])
    before = chart.lift(source)
    colour = before * np.exp(_log_gain(speaker, chart, person, before))
    rng = np.random.default_rng(person.seed)
    if person.freckles:
        colour = _add_freckles(colour, speaker, chart, person, rng)
    if person.stubble:
        colour = _add_stubble(colour, speaker, chart, person, rng)
    return chart.lay(add_dots(colour, speaker, chart, person))


def _changes(person: Person) -> bool:
    colours = person.skin, person.lips, person.hair
    return any(c is not None for c in colours) or bool(
        person.freckles or person.stubble or person.beads
    )


def _log_gain(speaker: Speaker, chart: Chart, person: Person, colour: Float32Array) -> Float32Array:
    """Logarithm (T, 3) of the factor by which each texel changes."""
    lip, (hair, hair_source) = regions.lips(speaker, chart), regions.hair(speaker, chart, colour)
    inside = regions.is_class(speaker, chart, "inner_mouth", "tongue")
    bare = regions.is_class(speaker, chart, "skin", "upper_lip", "lower_lip") * (1 - lip)
    skin_source = np.median(colour[regions.skin_sample(speaker, chart)], axis=0)
    lip_source = np.median(colour[regions.lip_sample(speaker, chart)], axis=0)
    lips = person.lips
    if lips is None and person.skin is not None:
        lips = lip_colour(person.skin)
    to_lips = _towards(lip_source, lips)
    luma = float(regions.LUMA @ (lip_source * np.exp(to_lips))) / float(regions.LUMA @ lip_source)
    out = np.outer(bare * (1 - hair), _towards(skin_source, person.skin)) + np.outer(lip, to_lips)
    if person.hair is not None:
        dyed = _dyed(colour, hair_source, person.hair)
        out += (bare * hair)[:, None] * np.log((dyed + 1) / (colour + 1))
    return np.asarray(out + inside[:, None] * np.log(luma), np.float32)


def _dyed(colour: Float32Array, source: Float32Array, target: tuple[int, int, int]) -> Float32Array:
    """Hair in another colour: its strands keep half of their contrast and lose their own tint."""
    strands = np.sqrt((colour @ regions.LUMA + 1) / (source @ regions.LUMA + 1))
    return np.asarray(np.outer(np.clip(strands, 0.5, 1.5), target), np.float32)


def _towards(source: Float32Array, target: tuple[int, int, int] | None) -> Float32Array:
    if target is None:
        return np.zeros(3, np.float32)
    return np.asarray(np.log(np.maximum(target, 1) / np.maximum(source, 1)), np.float32)


def _scatter(
    chance: Float32Array, chart: Chart, count: int, rng: np.random.Generator
) -> Float32Array:
    """Places (count, 3) drawn by a chance per mm^2 given for each texel."""
    weight = (chance * chart.area).astype(np.float64)
    chosen = rng.choice(len(weight), size=count, p=weight / weight.sum())
    return chart.place[chosen]


def _distance(
    chart: Chart, where: NDArray[np.bool_], points: Float32Array, limit: float
) -> Float32Array:
    """Distance (T,), mm, to the nearest of some points; `limit` outside of `where`."""
    out = np.full(len(chart.place), limit, np.float32)
    found = cKDTree(points).query(chart.place[where], distance_upper_bound=limit)[0]
    out[where] = np.minimum(found, limit)
    return out


def _add_freckles(
    colour: Float32Array, speaker: Speaker, chart: Chart, person: Person, rng: np.random.Generator
) -> Float32Array:
    chance = regions.freckled(speaker, chart)
    share = np.zeros(len(colour), np.float32)
    for radius, strength, number in _FRECKLES:
        away = _distance(chart, chance > 0, _scatter(chance, chart, number, rng), 2.0)
        share = np.maximum(share, strength * regions.step(away, 1.3 * radius, 0.4 * radius))
    return np.asarray(colour * np.exp(-np.outer(person.freckles * share, _PIGMENT)), np.float32)


def _add_stubble(
    colour: Float32Array, speaker: Speaker, chart: Chart, person: Person, rng: np.random.Generator
) -> Float32Array:
    """Darken the beard's region, with single hairs, towards the colour of stubble."""
    region = regions.beard(speaker, chart)
    hairs = _scatter(region, chart, _HAIRS, rng)
    away = _distance(chart, region > 0.01, hairs, 1.0)
    share = person.stubble * region * (0.22 + 0.34 * regions.step(away, 0.45, 0.12))
    hair = np.array(person.hair if person.hair is not None else (34, 28, 26), np.float32)
    shadow = 0.42 * hair + 0.38 * colour * np.array([0.90, 0.95, 1.04], np.float32)
    return np.asarray(colour + share[:, None] * (shadow - colour), np.float32)
