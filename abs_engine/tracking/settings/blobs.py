"""Settings of blobs of colour, a start without landmarks, and of shells that begin at them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class BlobSettings:
    """Settings of blobs of colour, a start without landmarks, and of shells that begin at them.

    Attributes
    ----------
    sure : float, posterior
        From which on a blob is taken for the mouth. Not measured.
    patience : float, s
        Without a sure blob, after which the whole picture is looked at again. Not measured.
    speed : float, mouth widths per s
        Standard deviation of a mouth's motion where it was just found. Not measured.
    jerk : float, mouth widths per s^2
        Standard deviation, how a head's motion changes. Not measured.
    noise : float, mouth widths
        That the blob's centre is off by, speech included. Not measured.
    reach : float, mouth widths
        That the lips' blob lies from where the head's pose, or the frames before, put the mouth.
        Not measured.
    area : float, squares of the mouth's width
        Usual area of lips. Not measured.
    least_area : float, share of the clip's median
        Of what is seen in an uncovered mouth. Not measured.
    most_area : float, times the clip's median
        The same at most. Not measured.
    least_posterior : float, share of the clip's median
        The same of the posterior. Not measured.
    least_face : float, share of the picture
        That the face's blob covers. Not measured.
    most_blobs : int
        Of lips, the largest. Not measured.
    least_lips : float, probability
        Of lips, below which a pixel is part of no blob. Not measured.
    least_pixels : int, pixels
        Of surely lips, with fewer of which there is no blob. Not measured.
    em_steps : int
        Of expectation and maximisation. Not measured.
    work : int, px
        Longer side of the picture in which blobs are looked for. Not measured.
    mouth : float, share of the area of a face as wide as the skin blob
        Usual area of the lips. Not measured.
    expected : tuple of float, widths of the skin blob
        Place of the lips across and down from the middle of its top. Not measured.
    expected_deviation : tuple of float, widths of the skin blob
        Standard deviation of that. Measured: a turn by 45 degrees moves them sideways by 0.37
        (three heads); hair over the forehead moves them up to 0.8 or down to 1.3.
    top : float, quantile
        Of the rows of the skin blob, that is its top. Not measured.
    looked_deviations : float, standard deviations
        About the expected place of the lips, in which they are looked for. Not measured.
    looked_lips : float, square roots of the lips' usual area
        That are looked at besides. Not measured.
    clutter : float, share of that area
        Expected to look like lips by chance. Not measured.
    parted : float, square roots of the lips' usual area
        Widest gap between the lips of one mouth. Not measured.
    clear : float, odds
        From which on it makes no difference how probable lips are. Not measured.
    stray : float, share of a blob's peak density
        Below which a pixel is part of none. Not measured.
    colour_spread : float, chromaticity
        That counts as much as a mouth's width does in place. Not measured.
    least_spread : tuple of float, squares of the looked-at width and of `colour_spread`
        Variances of a blob's place and colour that are added to its pixels'. Not measured.
    explained : float, share
        Explained over all, below which no mouth is accepted. Not measured.
    lips_shown : float, share
        The same over the lips. Not measured.
    in_picture : float, share
        Of the window around a shell, without which the mouth is outside of the picture. Not
        measured.
    starts : tuple of float, standard deviations
        Of the first modes that are tried where nothing is known of the posture. Not measured.
    started_modes : int
        Modes that are so tried. Not measured.
    by_blob : tuple of float, rad and mm
        Standard deviations of a pose that is the blob's across the line of sight. Not measured.
    """

    sure: float = 0.5
    patience: float = 0.5
    speed: float = 1.0
    jerk: float = 4.0
    noise: float = 0.06
    reach: float = 0.25
    area: float = 0.25
    least_area: float = 0.4
    most_area: float = 2.5
    least_posterior: float = 0.6
    least_face: float = 0.01
    most_blobs: int = 8
    least_lips: float = 0.2
    least_pixels: int = 4
    em_steps: int = 4
    work: int = 240
    mouth: float = 0.035
    expected: tuple[float, float] = (0.0, 1.0)
    expected_deviation: tuple[float, float] = (0.3, 0.3)
    top: float = 0.01
    looked_deviations: float = 3.0
    looked_lips: float = 2.0
    clutter: float = 0.15
    parted: float = 1.0
    clear: float = 20.0
    stray: float = 0.01
    colour_spread: float = 0.03
    least_spread: tuple[float, ...] = (1e-4, 1e-4, 0.05, 0.05)
    explained: float = 0.5
    lips_shown: float = 0.3
    in_picture: float = 0.5
    starts: tuple[float, ...] = (-1.5, 1.5)
    started_modes: int = 3
    by_blob: tuple[float, ...] = (1e-3, 1e-3, 1e-3, 3.0, 3.0, 0.1)


BLOB_START = BlobSettings()
