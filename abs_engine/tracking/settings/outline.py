"""Settings of a head's outline in the picture."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class OutlineSettings:
    """Settings of a head's outline in the picture.

    Attributes
    ----------
    side : int, px
        Of the longer side of what is drawn, at most. Not measured.
    least : int, places
        Of an outline, with fewer of which it says nothing. Not measured.
    apart : float, mm
        From place to place along the outline. Not measured.
    rim_blur : float, drawn pixels
        Standard deviation of the blur of the drawn head, whose slope is the outline's normal. Not
        measured.
    reach : float, mm
        Along the normal, to both sides, where an edge is looked for. Not measured.
    ear_reach : float, mm
        The same outward of an ear. Chosen by eye on p16 of the strangers' clips and on GRID's.
    step : float, mm
        From sample to sample. Not measured.
    least_blur : float, px
        Standard deviation of the picture's blur at least, against noise. Not measured.
    beside : tuple of float, mm
        Inward, between which the skin beside a place is seen. Not measured.
    spread : tuple of float, Lab of 8 bits
        Standard deviation of skin beside a place, of its shade and of its colour. Not measured.
    other : float, squared deviations
        From which on a colour is rather something else. Not measured.
    bare : float, squared deviations
        From the face's skin, up to which what lies beside a place is skin. Not measured.
    edge : float, mm times squared deviations
        By which colours beyond an edge must speak against skin. Not measured.
    ear : float, mm times squared deviations
        Of a stretch that is taken for an ear's skin. Not measured.
    grows : float, mm
        Standard deviation of an edge outside of the drawn head. Not measured.
    shrinks : float, mm
        The same of one inside of it. Chosen on eight films of other heads and by eye on p01 to p08
        of the strangers' clips: with 6, 3 and 2 heads come out 1.5, 0.8 and 0.4 mm too wide; the
        less it is believed, the less hair over cheeks narrows a head.
    pixels : float, px
        Standard deviation of an edge, as small faces are drawn coarsely. Not measured.
    alike : float, places
        That count as one, as they err together. Not measured.
    above_brows : float, mm
        Up to which the outline is looked at. Not measured.
    above_chin : float, mm
        From which on it is. Not measured.
    """

    side: int = 220
    least: int = 8
    apart: float = 4.0
    rim_blur: float = 3.0
    reach: float = 10.0
    ear_reach: float = 18.0
    step: float = 0.5
    least_blur: float = 0.5
    beside: tuple[float, ...] = (-14.0, -6.0)
    spread: tuple[float, ...] = (14.0, 5.0, 5.0)
    other: float = 9.0
    bare: float = 16.0
    edge: float = 20.0
    ear: float = 15.0
    grows: float = 2.0
    shrinks: float = 3.0
    pixels: float = 0.5
    alike: float = 4.0
    above_brows: float = 5.0
    above_chin: float = 3.0


OUTLINE = OutlineSettings()
