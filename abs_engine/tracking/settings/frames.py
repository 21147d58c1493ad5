"""Settings of the loop over frames: starts, light, and what is believed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class FrameSettings:
    """Settings of the loop over frames: starts, light, and what is believed.

    Attributes
    ----------
    recent : int, frames
        Whose value says what is usual. Not measured.
    least_explained : float, share
        That the fit of a talking face explains at least. Measured: of its own face 0.9 in film,
        0.65 in a blink, 0.56 in plain drawings; of a bare wall 0.1 to 0.2. Another face, 0.7 to
        0.9, is not distinguished.
    most_off : float, standard deviations
        RMS over the lips, that an accepted fit may lie off the landmarks: about 1.5 mm of a person
        who is known. Not measured.
    astray : float, standard deviations
        From which on the landmarks are taken to be wrong. Not measured.
    seen_width : float, standard deviations
        How far postures lie about those that were seen of a person. Not measured.
    step_deviation : float, standard deviations of a mode
        How far a posture moves in 40 ms. Measured: in speech by 0.3 (RMS of authored and of tracked
        motion), but in one step of a hundred by 1.1.
    look_across : float, px
        That the mouth is looked at in. Not measured.
    look_near : float, times the lips' outline
        Where what lies around it begins. Not measured.
    look_far : float, times the lips' outline
        Where it ends. Not measured.
    least_like : float, share of the usual
        Likeness of what lies within the outline, times that of what lies around it, below which the
        mouth is covered. Chosen on p01 to p08 of the strangers, where the least is 0.60, and a clip
        of GRID (bbaf2n) behind four made-up hands and cloths, where the most is 0.48. Measured on
        p09 to p16, 0.70, and on another clip (lrwp9a) behind such a hand, 0.38.
    usual_look : float, quantile
        Of the likenesses in some frames of a clip, that is usual, unless it would itself count as
        hidden beside the median. Chosen with p06 of the strangers in grey, whose closed mouth was
        called covered by the median. Measured: as a share of the median, 0.70 or more in the
        strangers' clips, also in four of them in grey; 0.3 where a drawn hand or mask hides the
        mouth in a third of the frames.
    usual_like : float, share of the median
        Of the likenesses, below which the quartile is not usual, however much skin lies around the
        mouth: a hand has as much. Measured: 0.2 behind hands in a third of the frames; 0.78 and
        more in p01 to p16 of the strangers, 13 changes of each, and clips of GRID, but 0.43 of a
        made-up mouth without colour that closes.
    usual_around : float, share of the median
        Of the skin around the mouth: with more of it, a mouth is taken to close, not to be hidden.
        Measured in the same clips: 0.8 and less behind the hand and the mask, 0.92 to 1.00 in the
        others.
    least_lips : float, share of the usual
        The same of lips within it. Not measured.
    least_in_picture : float, share of a mouth's outline
        That lies in the picture, or the mouth counts as outside of it. Chosen on a clip that was
        cut through the lower lip: with 0.7 all of its frames were tracked, with lips drawn on what
        lies beyond the border; with 0.9 a mouth 40 pixels wide is lost where one of them is cut.
    least_by_face : float, share of a mouth's outline
        The same where the picture cuts the face off, and the mouth's place follows from what lies
        off that border: of the outline's 20 points, all. Chosen on p01 to p08 of the strangers'
        clips, cut at many places. Measured on p09 to p16: of mouths that lack a quarter of their
        outline and more, 91 to 100 % are lost at the lower border (by their own landmarks 19 to
        75 %), 81 to 96 % at the sides (49 to 63 %); of whole mouths 12 and 3 %, all within 0.05 of
        the face's size of the border.
    light_none : float, logarithm
        Of a change of light up to which nothing is done. Measured: the largest change of GRID's
        clips is 0.03, of p01 to p08 of the strangers' clips 0.01 to 0.10, and 0.43 where the light
        does change.
    light_full : float, logarithm
        From which on all of it is undone. Measured with `light_none`.
    light_most : float, ratio
        Largest change that is taken for one of light. Not measured.
    light_black : float, levels of 255
        That are added before logarithms of light are taken: noise of what is nearly black counts
        less. Not measured.
    light_hue : float, logarithm
        By how much red, green and blue change beside each other, at most, in skin that keeps its
        hue. Measured: 0.14 and less in every fourth frame of p01 to p16 of the strangers, 0.21 and
        more in the same without their colour.
    hue_share : float, share of how they differ in the usual skin
        The same: pale colours change by less where they are lost. Measured on p16 with 0.6 of its
        colour, where they change by 0.11 to 0.13.
    light_dark : float, levels of 255
        Of the brightest channel of skin, below which a face that was brighter by more than
        `light_most` is too dark to say anything of the lips. Measured: in fades of p05 and p09 open
        lips came out surely closed at 9 and less, and within their intervals from 13 on.
    light_patch : float, share of the face's size
        Half the side of what is looked at about a landmark. Not measured.
    contradicted : float, standard deviations of both
        From which on an aperture and the landmarks' contradict each other. Not measured.
    """

    recent: int = 25
    least_explained: float = 0.35
    most_off: float = 2.6
    astray: float = 12.0
    seen_width: float = 0.5
    step_deviation: float = 0.8
    look_across: float = 48.0
    look_near: float = 1.25
    look_far: float = 1.75
    least_like: float = 0.54
    usual_look: float = 0.25
    usual_like: float = 0.3
    usual_around: float = 0.9
    least_lips: float = 0.2
    least_in_picture: float = 0.8
    least_by_face: float = 0.96
    light_none: float = 0.06
    light_full: float = 0.12
    light_most: float = 4.0
    light_black: float = 2.0
    light_hue: float = 0.15
    hue_share: float = 0.5
    light_dark: float = 12.0
    light_patch: float = 0.02
    contradicted: float = 2.0


FRAME_LOOP = FrameSettings()
