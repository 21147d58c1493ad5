"""Settings of the test for pictures in one strong tint."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class TintSettings:
    """Settings of the test for pictures in one strong tint.

    Chosen on the strangers' clips and GRID's, six frames each, in five tints (those of
    `tests/altered_clips.py` from night to amber) coded by x264 with CRF 18. None was held back.

    Attributes
    ----------
    cells : int, cells along each side of the picture
        That colours are averaged in. Chosen of 24, 32 and 48.
    samples : int, pixels along each side of a cell
        That are averaged, where there are as many. A bound on time. Not measured.
    levels : int
        Of luminance, by as many cells each, whose median chroma the curve of a tint is fitted to.
        Not measured.
    degree : int
        Of that curve, a polynomial in luminance. Chosen of 2 to 6: with fewer than 4, green whose
        highlights are pale is off by up to 4.8 levels; more let colours seem a tint.
    luminance_unsure : float, levels of 255
        That luminance is off by where chroma is off by one, as video's chroma is coarser. Chosen
        of 2 to 8: with more, colours that change as luminance does would count as tints.
    stray : float, share of the cells
        That do not count. Chosen of 0 to 0.2.
    most_off : float, levels of 255
        RMS distance of the colours from the curve, below which they are of one tint. Measured, for
        CRF 18: up to 2.0 in tinted clips; in colour 2.7 and more, in `warm` and `blue` light, too.
    most_off_face : float, levels of 255
        The same of the face alone, where all cells count, as lips are few. Measured: up to 2.0 in
        tinted clips, but 3.5 in p13 and 3.9 in p03, 128 pixels wide, in green; of drawn heads in
        `warm` light, whose skin has less texture than people's, 4.3 and more in three of six, but
        3.0, 2.9 and 2.6 in the others.
    most_share : float, share of the tint's RMS chroma
        That this distance is below, too: faded colours are no tint. Measured: up to 0.038 in tinted
        clips, but 0.05 in p03, 128 pixels wide, in navy and orange; in colour 0.055 and more.
    around : float, share of a face's width and height
        On each side of it that counts as around it. As the landmark network sees it. Not measured.
    """

    cells: int = 24
    samples: int = 4
    levels: int = 16
    degree: int = 4
    luminance_unsure: float = 2.5
    stray: float = 0.05
    most_off: float = 2.3
    most_off_face: float = 3.6
    most_share: float = 0.045
    around: float = 0.25


TINT = TintSettings()
