"""Colours and strokes: systems apart for every eye, heads in calm clay, errors in viridis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.report.drawing.palette import colours_of

TRUTH = "#1a1a1a"
SYSTEMS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
"""The palette of Okabe & Ito (2008), which people with any colour vision can tell apart."""

TRUTH_ON_PICTURES = "#ffffff"
_ON_PICTURES = ("#14a5ff", "#ff7f27", "#2be3a6", "#ff9ad2", "#ffd43d", "#a6e4ff")

_GAPS = ((), (12, 10), (3, 5), (16, 5, 3, 5), (7, 14), (2, 9))
"""Dashes and gaps of the systems' lines, px."""

_WIDEST, _THINNER, _THINNEST, _TRUTH_WIDTH = 2.6, 0.4, 1.6, 4.8  # px
_ON_PICTURE_WIDTH, _TRUTH_ON_PICTURE_WIDTH = 1.4, 3.0

HEAT_COLOURS = colours_of("viridis")
"""Colours (256, 3) uint8 of errors, from none to the scale's end."""

CLAY = (208, 192, 178)
_CLASS = {
    "skin": CLAY,
    "upper_lip": (176, 92, 88),
    "lower_lip": (176, 92, 88),
    "inner_mouth": (96, 48, 50),
    "upper_teeth": (244, 240, 230),
    "lower_teeth": (244, 240, 230),
    "tongue": (190, 112, 112),
    "eyes": (214, 211, 204),
}
_ENDS = (1, 2, 4, 6, 8, 10)  # so that quarters are round numbers


@dataclass(frozen=True)
class Stroke:
    """Style of a line. Lines in the same place are all seen: later ones lie above.

    Parameters
    ----------
    colour : str
        As CSS.
    width : float
        Pixels.
    gaps : tuple of int
        Lengths of dashes and gaps, px; empty for a whole line.
    """

    colour: str
    width: float
    gaps: tuple[int, ...] = ()

    @property
    def dash(self) -> str:
        """The gaps as plotly names them."""
        return ",".join(f"{n}px" for n in self.gaps) or "solid"


def truth_stroke() -> Stroke:
    """The truth in charts: broad, so that it is seen behind a line that meets it."""
    return Stroke(TRUTH, _TRUTH_WIDTH)


def system_stroke(number: int) -> Stroke:
    """A system in charts, by its place: the gaps show what lies behind."""
    width = max(_WIDEST - _THINNER * number, _THINNEST)
    return Stroke(system_colour(number), width, _GAPS[number % len(_GAPS)])


def picture_stroke(number: int | None) -> Stroke:
    """A system, or with None the truth, on pictures of faces."""
    if number is None:
        return Stroke(TRUTH_ON_PICTURES, _TRUTH_ON_PICTURE_WIDTH)
    gaps = _GAPS[number % len(_GAPS)]
    return Stroke(picture_colour(number), _ON_PICTURE_WIDTH, gaps)


def system_colour(number: int) -> str:
    """Colour of a system by its place, as CSS."""
    return SYSTEMS[number % len(SYSTEMS)]


def picture_colour(number: int) -> str:
    """The same for lines on pictures of faces, where it has to be brighter."""
    return _ON_PICTURES[number % len(_ON_PICTURES)]


def rgb(colour: str) -> tuple[int, int, int]:
    """Red, green and blue of a CSS colour '#rrggbb'."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def clay_colours(
    faces: NDArray[np.integer],
    facet_class: NDArray[np.integer],
    class_names: tuple[str, ...],
    vertices: int,
) -> NDArray[np.uint8]:
    """Colours (V, 3) uint8 of a head's vertices by the classes of its facets (F,)."""
    out = np.tile(np.array(CLAY, np.uint8), (vertices, 1))
    for number, colour in enumerate(clay_of(class_names)):
        if (colour != CLAY).any():
            out[np.unique(faces[facet_class == number])] = colour
    return out


def clay_of(class_names: Sequence[str]) -> NDArray[np.uint8]:
    """Colours (K, 3) uint8 of classes of facets; skin's for a name that is none of a face."""
    return np.array([_CLASS.get(name, CLAY) for name in class_names], np.uint8)


def scale_end(maps: Sequence[FloatArray]) -> float:
    """End of the scale of errors (mm): above 98 % of them, rounded up; 1 without errors."""
    known = [m[np.isfinite(m)] for m in maps]
    values = np.concatenate([np.zeros(0), *known])
    high = float(np.quantile(values, 0.98)) if values.size else 0.0
    if high <= 0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(high))
    return float(next(k * power for k in _ENDS if k * power >= high * (1 - 1e-9)))
