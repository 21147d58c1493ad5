"""Settings of close-ups by a camera worn before the mouth."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class WornSettings:
    """Settings of close-ups by a camera worn before the mouth.

    Attributes
    ----------
    whole_face : float, share of the picture's shorter side
        Size of a face up to which a picture is no close-up. Measured: of 24 close-ups two seem to
        hold a face, of 0.88 and 0.97; three clips of whole faces have 0.43 to 0.6.
    fitted : int, frames
        Of a clip, spread evenly, that its mouth is fitted to. Not measured.
    learned : int, frames
        Of a clip, spread evenly, that a mouth's looks are learned from without a model: as many to
        twice as many, where there are so many. Chosen on close-ups cut from p02, p03 and p05 of the
        strangers' clips: apertures correlate with the whole face's by 0.93 to 0.98; by 0.69 to 0.90
        where only `fitted` were learned from.
    seen : int, frames
        That these are spread over at most. A bound on time. Not measured.
    rounds : int
        Of learning colours and fitting, without a model of mouths. Not measured.
    joint_limit : int, evaluations
        Of the fit of place and person at most. Not measured.
    wider : tuple of float, mouth widths
        That the first window is wider and higher by: the mouth is about there. Not measured.
    face : float, mouth widths
        That a face is wide. Not measured.
    below : float, faces
        By which the mouth lies below the middle of one. Not measured.
    first_width : float, share of the picture's width
        That the mouth is taken to have at first. Not measured.
    looks : int
        At each frame, each where the one before put the mouth. Not measured.
    starts : tuple of tuple of float, shares of the picture and of the usual width
        Right and down from the picture's middle, and how wide: where a mouth is looked for first,
        to see whether there is one. Not measured.
    asked : int, frames
        In which that is done. Measured: of four, two are astray in one of p01 to p08.
    turned : float, probability
        Of a face in the picture turned by 180 degrees, above which it is upside down, if it is less
        upright. Chosen on close-ups cut from p01 to p08 of the strangers' clips: at most 0.04
        turned the wrong way; the right way 0.1 and more in five of eight. Measured on p09 to p16
        and 24 worn cameras: at most 0.022, and 0.1 and more in 20 of 32.
    most_unsettled : float, standard deviation of the logarithm of the mouth's width
        Up to which there is one. Chosen on close-ups cut from p01 to p08 of the strangers' clips:
        at most 0.008 with two widths of the mouth and more in the picture; of their eyes and hair
        0.079 and more, but once (0.012). Measured on 24 worn cameras, at most 0.015, and on p09 to
        p16, at most 0.009, and 0.065 and more. Where little more than the mouth is in the picture,
        four of 15 mouths have 0.2 to 0.3.
    most_unlike : float, nats
        Up to which a model of mouths suits a clip, by `learn.opening.disagreement` with the
        landmarks. Chosen on five speakers of labelled close-ups, each by a model of nine others (at
        most 0.85), and p01 to p08 of the strangers' clips by a model of all ten (1.67 and more,
        but for two that it opens rightly). Measured on 19 other speakers, at most 1.06, and on p09
        to p16: more in six of eight.
    """

    whole_face: float = 0.8
    fitted: int = 12
    learned: int = 24
    seen: int = 1200
    rounds: int = 4
    joint_limit: int = 60
    wider: tuple[float, float] = (0.4, 0.4)
    face: float = 2.9
    below: float = 0.27
    first_width: float = 0.43
    looks: int = 3
    starts: tuple[tuple[float, float, float], ...] = (
        (0.0, 0.0, 1.0),
        (-0.12, 0.0, 1.0),
        (0.12, 0.0, 1.0),
        (0.0, -0.12, 1.0),
        (0.0, 0.12, 1.0),
        (0.0, 0.0, 0.75),
        (0.0, 0.0, 1.3),
    )
    asked: int = 8
    turned: float = 0.1
    most_unsettled: float = 0.04
    most_unlike: float = 1.3


CLOSE_UP = WornSettings()
