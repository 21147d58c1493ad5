"""Regions of a painted face: shares from 0 to 1 of skin, lips, hair, beard for every texel.

Places are millimetres on the average head, so a region is where it should be on every person.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from abs_engine.core.arrays import Float32Array
from abs_engine.io.assets import Speaker
from abs_engine.studio.people.chart import Chart

LUMA = np.array([0.299, 0.587, 0.114], np.float32)
_HAIR_FROM = ((0, 25, 38, 52, 64, 74, 90, 130, 180), (88, 88, 80, 46, 24, 8, -14, -34, -48))
"""No cropped hair grows below this: degrees from the front, height in mm."""
_BEARD_BELOW = ((0, 20, 34, 50, 66, 80), (-6, -12, -34, -36, -12, 10))
"""No beard grows above this: distance from the middle, height, in mm."""
_FAR = 8.0
"""mm from the border of the lips, beyond which its distance is not needed."""


def step(x: NDArray[np.floating], low: float, high: float) -> Float32Array:
    """Rise smoothly from 0 at `low` to 1 at `high`, or fall where low > high."""
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t), np.float32)


def bump(place: Float32Array, centre: tuple[float, float, float], radius: float) -> Float32Array:
    """A Gaussian spot on both sides of the head around a place on its left."""
    offset = np.abs(place * [1, 0, 0]) + place * [0, 1, 1] - centre
    return np.asarray(np.exp(-(offset**2).sum(axis=1) / radius**2), np.float32)


def is_class(speaker: Speaker, chart: Chart, *names: str) -> NDArray[np.bool_]:
    """Mask of the texels (T,) that belong to facets of some classes."""
    return np.isin(chart.kind, [speaker.class_id(n) for n in names])


def lips(speaker: Speaker, chart: Chart) -> Float32Array:
    """Share (T,) of lip colour: soft within half a millimetre of the border of the lips."""
    inside = is_class(speaker, chart, "upper_lip", "lower_lip")
    outside = np.where(inside, -1.0, 1.0) * border_distance(speaker, chart)
    reach = inside | is_class(speaker, chart, "skin")
    return step(outside, 0.45, -0.45) * reach


@lru_cache(maxsize=1)
def border_distance(speaker: Speaker, chart: Chart) -> NDArray[np.float64]:
    """Distance (T,), mm, to the border between lips and skin, not more than `_FAR`."""
    ring = speaker.vertices[speaker.lip_ring].astype(np.float64)
    along = np.linspace(0, 1, 20, endpoint=False)[:, None, None]
    border = (ring + along * (np.roll(ring, -1, axis=0) - ring)).reshape(-1, 3)
    low, high = border.min(axis=0) - _FAR, border.max(axis=0) + _FAR
    near = ((chart.place > low) & (chart.place < high)).all(axis=1)
    out = np.full(len(chart.place), _FAR)
    out[near] = np.minimum(cKDTree(border).query(chart.place[near])[0], _FAR)
    out.flags.writeable = False  # it is kept
    return out


def skin_sample(speaker: Speaker, chart: Chart) -> NDArray[np.bool_]:
    """Texels (T,) of forehead, cheeks and nose, whose median is the skin's colour."""
    x, y, z = np.abs(chart.place[:, 0]), chart.place[:, 1], chart.place[:, 2]
    cheeks, forehead = (x < 50) & (y > 3) & (y < 22), (x < 32) & (y > 62) & (y < 80)
    return is_class(speaker, chart, "skin") & (cheeks | forehead) & (z > 60)


def lip_sample(speaker: Speaker, chart: Chart) -> NDArray[np.bool_]:
    """Texels (T,) of the lips that are seen when the mouth is closed."""
    outside = border_distance(speaker, chart)
    own = is_class(speaker, chart, "upper_lip", "lower_lip")
    return own & (outside > 0.8) & (outside < 4.0)


def hair(speaker: Speaker, chart: Chart, colour: Float32Array) -> tuple[Float32Array, Float32Array]:
    """Share of hair in each texel, seen from its colour, and the hair's median colour.

    On the skull a texel lies between the colours of skin and of hair; in the brows and on the lid
    margins, hair is what is much darker than skin.

    Returns
    -------
    share : (T,) float32
    median : (3,) float32, 0 to 255
    """
    skin = is_class(speaker, chart, "skin")
    x, y, z = chart.place.T
    azimuth = np.degrees(np.arctan2(np.abs(x), z + 8.0))
    on_skull = skin & (y > np.interp(azimuth, *_HAIR_FROM))
    middle = np.median(colour[skin_sample(speaker, chart)], axis=0)
    crop = np.median(colour[on_skull & (azimuth > 70) & (azimuth < 110) & (y > 40)], axis=0)
    towards = np.log(crop + 2) - np.log(middle + 2)
    along = (np.log(colour + 2) - np.log(middle + 2)) @ towards / (towards @ towards)
    dark = step((colour @ LUMA) / (middle @ LUMA), 0.85, 0.55)
    front = skin & (z > 45) & (y > 30) & (y < 64) & (np.abs(x) < 58)
    share = np.where(on_skull, step(along, 0.25, 0.85), np.where(front, dark, 0))
    return np.asarray(share, np.float32), np.asarray(crop, np.float32)


def beard(speaker: Speaker, chart: Chart) -> Float32Array:
    """Share (T,) of the beard's region: jaw, chin and upper lip, not the lips themselves."""
    x, y, z = chart.place.T
    share = step(np.interp(np.abs(x), *_BEARD_BELOW) - y, 0, 9) * step(y, -88, -66)
    share *= step(z, 2, 22) * step(border_distance(speaker, chart), 0.8, 4.0)
    return np.asarray(share * is_class(speaker, chart, "skin"), np.float32)


def freckled(speaker: Speaker, chart: Chart) -> Float32Array:
    """Share (T,) of where freckles are: nose and cheeks, fading out; not on lids and lips."""
    share = bump(chart.place, (0, 12, 104), 22) + bump(chart.place, (34, 8, 82), 20)
    share *= step(chart.place[:, 1], 34, 24) * step(chart.place[:, 2], 50, 60)
    share *= is_class(speaker, chart, "skin") & (border_distance(speaker, chart) > 2)
    return np.asarray(np.where(share > 0.03, np.minimum(share, 1), 0), np.float32)
