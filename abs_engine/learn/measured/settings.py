"""Settings of faces of measured points: the head that is fitted to them, and what it leaves."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class MeasuredFaceSettings:
    """Settings of faces of measured points: the head that is fitted to them, and what it leaves.

    Attributes
    ----------
    unfolded : float, weight of `jawOpen`
        Of the posture in which places are compared: lips that touch lie apart in it, so that one
        does not move as the other. Not measured.
    least : int, points
        That make a face. Not measured.
    least_lips : int, points
        Of the group lips among them. Not measured.
    least_others : int, points
        Of no lip or tooth. Not measured.
    farthest : float, mm RMS
        That points lie off the head that was fitted to them at most. Measured: of mei, kofi and
        walter 0.5 to 0.7, upside down 5.1 and more, in cm, or 1.3 times as large, 0.7 to 2.2.
    unlikely : float, standard deviations RMS
        Of its identity at most. Measured with `farthest`: 0.5 to 0.8, 3.7 and more, 1.3 to 2.7.
    noise : float, mm
        Standard deviation of a coordinate about the head's face units. Not measured.
    nearing : tuple of tuple of float, mm
        Across and along the surface, in each round in which places are still guessed by distance
        alone. Not measured.
    rounds : int
        By motion. Not measured.
    sliding : float, mm
        By which a place may be off along the surface as motion says. Not measured.
    across : float, mm
        Across the surface that identity then leaves of a point: more than it is off alone, as
        neighbours err together. Chosen of 0.3 to 1 on clara and kofi.
    along : float, mm
        The same along it. Chosen of 1 to 8 on clara and kofi.
    turn : float, rad
        Standard deviation of what a round turns the frame by. Not measured.
    shift : float, mm
        The same of what it moves it by. Not measured.
    most_moved : float, mm
        That a point is moved at once. Not measured.
    reaches : tuple of float, mm
        Standard deviations of the Gaussians that are tried; points left out choose. Not measured.
    noises : tuple of float, share of the field's variance
        Variances of the points' noise that are tried; points left out choose. Not measured.
    folds : int
        In which points are left out. Not measured.
    tried : int, facets
        About a point, of which the nearest is its own. Not measured.
    """

    unfolded: float = 0.7
    least: int = 12
    least_lips: int = 4
    least_others: int = 4
    farthest: float = 3.0
    unlikely: float = 1.3
    noise: float = 0.3
    nearing: tuple[tuple[float, float], ...] = (
        (2.0, 6.0), (1.0, 5.0), (0.7, 4.0), (0.5, 3.0), (0.5, 2.0),
    )  # fmt: skip
    rounds: int = 10
    sliding: float = 0.75
    across: float = 0.6
    along: float = 3.0
    turn: float = 0.1
    shift: float = 10.0
    most_moved: float = 3.0
    reaches: tuple[float, ...] = (8.0, 15.0, 25.0, 40.0)
    noises: tuple[float, ...] = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0)
    folds: int = 10
    tried: int = 32


MEASURED_FACE = MeasuredFaceSettings()
