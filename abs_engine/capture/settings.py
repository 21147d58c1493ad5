"""Settings of measured points: boards, cameras, dots that are followed, and the head's frame."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class CaptureSettings:
    """Settings of measured points: boards, cameras, dots that are followed, and the head's frame.

    Attributes
    ----------
    least_corners : int, corners
        Of a board in sight, with fewer of which a picture is not used. Not measured.
    least_markers : int, markers
        The same of the markers of a ChArUco board. Not measured.
    marker_off : float, sides of a marker
        That its corners may be off a flat board: a lens bends it a little. Not measured.
    corner_window : tuple of int, px
        Half the side of the window in which a chessboard's corner is moved to its saddle, least and
        largest; between them, a third of the way from corner to corner. Not measured.
    least_pictures : int, pictures
        Of a board, by which a camera or two are calibrated. Not measured.
    least_common : int, corners
        That both cameras see at the same moment, for it to count. Not measured.
    tilt : float, degrees
        By which the board must be turned between some two of the pictures. Not measured.
    vague : float, share of a focal length
        Largest standard deviation of it. Not measured.
    tangential : float, standard deviations
        From 0, below which tangential coefficients are left out: with a long lens they are hardly
        distinguished from a shift of the principal point, which is then twice as uncertain. Not
        measured.
    cameras_apart : float, share of the board's distance
        Between two cameras at least, 0.6 degrees. Not measured.
    together : float, errors of the worse camera alone
        Largest error of two cameras together. Not measured.
    small_error : float, share of the picture's longer side
        Or so much, if that is more. Chosen: in twelve drawn pairs, two that are exchanged make ten
        times that, and a board that moves by 0.5 mm between both pictures two thirds of it.
    mirror_error : float, px
        Above which no flat mirror explains the pictures. Not measured.
    mirror_margin : float, share of its size
        By which a mirror is larger than what was seen in it. Not measured.
    narrowest : float, degrees
        Angle between lines of sight, below which they tell too little about depth. Not measured.
    largest_error : float, px
        Of a triangulated point in its views, unless another is given. Not measured.
    radii : tuple of float, px
        Radii of dots that are tried, from the first to the second by steps of the third. Not
        measured.
    larger_radii : tuple of float, px
        The same of those tried after that where the first or the last of `radii` is the best, or
        none correlates by `least`. Not measured.
    surround : float, radii
        Half the side of a dot's window: the dot, and as much of the skin around it. Not measured.
    dot_blur : float, px
        Of lens and sampling at a dot's edge. Not measured.
    dot_core : float, radii
        Up to which it is surely dot. Not measured.
    bare : tuple of float, radii
        Between which the bare surface lies. Not measured.
    colour_ridge : float, share of the mean variance
        That is added to the colours' covariance, against fitting noise. Not measured.
    reach : float, radii
        How far from where it is expected a dot is looked for. Not measured.
    least : float, correlation
        With a disc, below which a dot is lost. Measured in a filmed session: dots between 0.5 and
        0.55 were off by 1.3 mm, those above by 0.6 and less.
    sure : float, correlation
        The same, below which it is found but marked as uncertain. Not measured.
    stray : float, radii
        From where its neighbours went since it was sure, beyond which an uncertain dot is lost:
        what is there is something else that is round. Not measured.
    snap : float, radii
        By which a place that a person gives is moved to the best dot at most. Not measured.
    same : float, px
        Apart, below which two dots that a person gives were moved to the same one. Not measured.
    miss : float, costs
        Of leaving a dot without a place: a squared distance of `reach` costs 1. Not measured.
    unlike : float, costs
        Of not correlating at all with how a dot looked before, or with a disc. Not measured.
    dot_patch : float, radii
        Half the side of the patch that is remembered of a dot. Not measured.
    neighbours : int, dots
        Whose motion says where a dot is expected. Not measured.
    rates_apart : float, share
        By which the frame rates of two videos may differ. Not measured.
    times_apart : float, frames
        Between frames of one number in two videos, by the files' times, at most. Not measured.
    uneven : float, ratio
        Of a step in time and the usual one, or the reverse, at most. Not measured.
    smallest : float, mm
        That a face's points extend over at least. Chosen: lips alone over 40, a face in cm 23.
    flat : float, mm RMS
        That rigid points lie off a straight line at least. Not measured.
    off_reference : float, mm RMS
        That rigid points may lie off a reference. Chosen: rules and callipers err by 1 to 3; where
        cm are taken for mm, or sides are exchanged, 10 and more are usual.
    farthest : float, mm
        That half of the points may lie from the head's origin. Chosen: a face's lie within 150.
    wild : float, mm
        From its median place, at which no point of a face can be. Chosen: a chin moves by 50.
    wide : float, mm
        From their middle, at which half of a face's points may lie. Chosen: usual are 20 to 70, and
        200 and more if mm are taken for cm.
    moved : float, mm
        From their median places, that two points lie at least if they have each other's. Measured
        with `nearer`.
    nearer : float, share of how far two points are off
        That is left once they are exchanged, if they were mixed up. Measured about medians in
        corpora of six bundled and four drawn people, of 275 and of 30 points, of 68, 8 and 5
        visemes: none of 420 is refused as it is. Of 900 pairs that were mixed up in one viseme, all
        850 that lie 20 mm or more apart are named, 40 of 41 that lie 10 to 20 mm apart, 2 of 9
        others.
    crossed_frames : int
        In which points are tried with each other's names in one view, at most. A bound on time.
        Not measured.
    lips_behind : float, mm
        In front of the upper front teeth's edge, that lips lie at least. Chosen: usual are 2 to 12.
    """

    least_corners: int = 8
    least_markers: int = 4
    marker_off: float = 0.25
    corner_window: tuple[int, int] = (2, 10)
    least_pictures: int = 3
    least_common: int = 6
    tilt: float = 5.0
    vague: float = 0.03
    tangential: float = 3.0
    cameras_apart: float = 0.01
    together: float = 5.0
    small_error: float = 1 / 640
    mirror_error: float = 3.0
    mirror_margin: float = 0.1
    narrowest: float = 3.0
    largest_error: float = 1.5
    radii: tuple[float, float, float] = (1.0, 8.0, 0.25)
    larger_radii: tuple[float, float, float] = (8.5, 32.0, 0.5)
    surround: float = 1.9
    dot_blur: float = 0.7
    dot_core: float = 0.6
    bare: tuple[float, float] = (1.6, 2.4)
    colour_ridge: float = 0.02
    reach: float = 6.0
    least: float = 0.55
    sure: float = 0.7
    stray: float = 2.0
    snap: float = 1.5
    same: float = 0.5
    miss: float = 1.3
    unlike: float = 1.0
    dot_patch: float = 2.2
    neighbours: int = 4
    rates_apart: float = 1e-3
    times_apart: float = 0.5
    uneven: float = 1.5
    smallest: float = 35.0
    flat: float = 2.0
    off_reference: float = 4.0
    farthest: float = 300.0
    wild: float = 150.0
    wide: float = 200.0
    moved: float = 7.0
    nearer: float = 0.5
    crossed_frames: int = 20
    lips_behind: float = -10.0


CAPTURE = CaptureSettings()
