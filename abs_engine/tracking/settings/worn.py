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
    """

    whole_face: float = 0.8
    fitted: int = 12
    seen: int = 1200
    rounds: int = 4
    joint_limit: int = 60
    wider: tuple[float, float] = (0.4, 0.4)
    face: float = 2.9
    below: float = 0.27
    first_width: float = 0.43
    looks: int = 3


CLOSE_UP = WornSettings()
