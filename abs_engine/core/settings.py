"""Settings of what all stages share: cameras, pictures that are made smaller, and first steps."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class GeneralSettings:
    """Settings of what all stages share: cameras, pictures that are made smaller, and first steps.

    Attributes
    ----------
    focal : float, longer sides of the picture
        Focal length of a camera that nothing is known of. Not measured.
    nearest : float, mm
        From the camera: no face is nearer to it. Not measured.
    finest : float, drawn pixels for one of the picture
        At most: what is drawn finer shows no more. Not measured.
    window_blur : float, drawn pixels
        Standard deviation of the blur of a window that is drawn coarser than the picture. Not
        measured.
    shrunk_blur : float, pixels of the smaller picture
        The same of a part of a picture that is looked at coarsely. Not measured.
    pose_step : tuple of float, rad and mm
        First steps of a pose, at a solver's step 1. Not measured.
    pose_reach : tuple of float, rad and mm
        That a pose may be corrected by at most. Not measured.
    mode_step : float, standard deviations
        First step of a weight, at a solver's step 1. Not measured.
    """

    focal: float = 1.7
    nearest: float = 50.0
    finest: float = 2.0
    window_blur: float = 0.5
    shrunk_blur: float = 0.4
    pose_step: tuple[float, ...] = (0.02, 0.02, 0.02, 0.8, 0.8, 4.0)
    pose_reach: tuple[float, ...] = (0.5, 0.5, 0.5, 25.0, 25.0, 200.0)
    mode_step: float = 0.5


GENERAL = GeneralSettings()
