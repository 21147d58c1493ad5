"""Settings of the head's poses and shape, by landmarks, pupils and texture."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class HeadSettings:
    """Settings of the head's poses and shape, by landmarks, pupils and texture.

    Attributes
    ----------
    pupil_noise : float, mm
        That each pupil is off by itself. Not measured.
    pixel_noise : float, px
        The same in the picture. Not measured.
    landmarks_alike : float, landmarks
        That count as one, as they err together, where a frame is compared with others of the
        person. Their factors were learned on drawn heads, whose faces move less; a jaw that opens
        wide pulls all landmarks down with it. Chosen on eight films of other heads; 32 does no
        better.
    rounds : int
        Of landmarks and texture, the joint fit. Chosen on two sets of films of other heads and on
        `p01` to `p08`: with 1, 2 and 3 rotation is off by 1.6, 1.4 and 1.5 degrees in the films;
        apertures and motion are alike with 2 and 3. In six sets of films rotation is off by 1.32
        degrees with 2, 1.35 with 3; in two of these the face is turned by 0.1 and 0.2 degrees more
        against the true one with 2.
    known_rounds : int
        The same for a known imported head. Chosen of 2 and 3 on a set of films: rotation off by
        0.55 and 0.49 degrees, lips by 3.0 and 2.9 mm.
    first_steps : int
        Gauss-Newton steps by landmarks and pupils alone. Not measured.
    steps : int
        Gauss-Newton steps in each round. Not measured.
    frame_steps : int
        Gauss-Newton steps of a frame's pose at most. Not measured.
    frame_settled : float, rad and standard deviations
        After a step by less, the next hardly moves the head of a frame, or its landmarks, and is
        left out. Measured: with 0.001 for landmarks, poses, apertures and motion in 48 films of
        other heads are alike.
    start_settled : float, rad and standard deviations
        The same of landmarks alone, from which the texture sets out. Measured: with 0.003 poses,
        apertures and motion of two sets of films and of 16 strangers are alike.
    settled : float, rad and standard deviations
        The same of the joint fit. Not measured.
    identity_counts : float, rad per standard deviation
        By which a step of the identity counts in that. Not measured.
    near : int, frames
        That each is compared with, those that face most alike. Chosen of 3 and 5 on the films of
        `side`: 1.5 and 1.7 degrees.
    known_near : int, frames
        The same for a known imported head. Chosen on seed 1 of the films of `side`, whole runs:
        lips off by 2.8 mm with 5, 3.1 with 3; with `joint_alike`, 2.6 with 5 and with 7.
    joint_alike : float, landmarks
        That count as one in the joint fit: what makes them err stays, in part, from frame to frame.
        Chosen of 1, 4 and 16 on known imported heads, whose lips are off by 2.8, 2.6 and 2.6 mm,
        and of 1, 2, 3, 4 and 16 on 32 films of unknown ones (seeds 1 to 4) by the mean of rotation,
        the same in the person's own frame and how far faces are turned: 1.40, 1.37, 1.36, 1.37 and
        1.44 degrees with `still` 1. Measured on 32 others (seeds 5 to 8): 1.51 with 1, 1.32 with 4.
    most_turn : float, rad
        In a step. Not measured.
    scale_held : float, mm
        Standard deviation of the pupils' distance in the joint fit where the usual one is taken:
        sharp, as nothing else in a clip says the size. Not measured.
    given_held : float, mm
        The same where it is given. Chosen on eight films of other heads: with 0.5, landmarks make
        heads up to 3 % smaller than the distance that was given.
    eyes_unseen : float, share of all lengths
        Standard deviation that is added to the scale's where the picture cuts the eyes off.
        Measured on p01 to p08 of the strangers' clips and four of GRID, 25 crops below the eyes:
        the head is found larger or smaller than in the whole picture by 0.05 (RMS) with half of the
        nose in the picture, by 0.08 with one clip that was cut at its tip, where it is 0.36 larger.
    given_apart : float, degrees
        By which given poses may turn unlike the face in the median frame, after a constant turn.
        Not measured: by landmarks and texture a clip's poses are off by less than a degree.
    given_away : float, mm
        By which they may place it elsewhere there. Not measured.
    given_origin : float, mm
        Standard deviation of where the origin of their head lies. Not measured.
    given_deviation : tuple of float, rad and mm
        The same of a given pose, once aligned. Chosen on films of two people with their true poses:
        with three times as much, landmarks move them by 0.5 and 0.2 degrees instead of 0.1 and
        0.04.
    given_step : tuple of float, ratio and mm
        First steps of scale and origin of given poses. Not measured.
    side : int, px
        Longer side of the pictures that are compared, at most. Chosen on 24 films of other heads
        (seeds 1 to 3), joint fit: faces lie 1.8 degrees off the true ones with 220, and 1.6 with
        320; 440 is no better.
    margin : float, px
        Of picture around skin whose texture, or outline, is compared. Not measured.
    shading : int, drawn pixels
        Radius of the blur that is subtracted from both pictures. It stands for shading, which does
        not move with the skin. Chosen on the same films: 1.6 degrees without it; 1.54, 1.51, 1.48
        and 1.49 with Gaussian blurs of standard deviation 3, 4.5, 6 and 12. That of the blur used
        here is about 6.
    most_points : int
        Points of texture that are followed. Measured on the films of `side`: 240 are no better.
    least_apart : float, drawn pixels
        Between such points at least. Not measured.
    least_points : int
        Points without which two frames are not compared. Not measured.
    facing : float, cosine
        Between the surface and the line of sight at least. Not measured.
    levels : int
        Of the pyramid that flow is sought in. Not measured.
    returns : float, pixels of what is compared
        By which flow there and back misses where it began, at most; of followed heads, too. Not
        measured.
    flow_reach : float, drawn pixels
        That flow leads at most. Not measured.
    still : float, mm
        By which the mouth's modes move skin at most whose texture is compared. Chosen of 1, 1.2,
        1.5 and 2 with the postures that `scanned_units` changed, which move more skin, on the films
        and by the measures of `joint_alike`: 1.44, 1.40, 1.38 and 1.40 degrees, within chance. The
        demo's known head is off by 1.28 mm instead of 1.26.
    above : float, mm
        Above the lips that such skin lies at least. Not measured.
    scalp : float, mm
        Above the lips that such skin of a known imported head lies at most. Chosen on seed 1 of the
        films of `side`, joint fit: rotation off by 0.98, 0.92 and 0.93 degrees with 100, 115 and
        130, and by 1.97 with the whole scalp, which is seen at a grazing angle. Heads whose shape
        is fitted gain nothing on average.
    front : float, mm
        In front of the head's origin that it lies at least. Not measured.
    most_slide : float, mm
        Along the surface to which a match is taken at most. Not measured.
    grazing : float, cosine
        Between ray and normal that is counted at the flattest. Not measured.
    match_noise : float, pixels of what is compared
        Standard deviation of a match. Chosen for the joint fit on the same films as `side`: 1.48
        degrees with 0.7, 1.44 with 0.5. Not measured for followed heads, for which it counts, too.
    matches_alike : float, matches
        That count as one, as they err together. Not measured.
    gaze : tuple of float, mm
        How far eyes that look elsewhere take both pupils along, across and down the face. Not
        measured.
    clear : float, standard deviations of a match
        By which a frame's matches are off in the median, at most, where its texture is seen
        clearly; elsewhere a head is expected to have turned little since the frame before. Chosen
        between what was measured: 0.4 to 0.6 in most frames of films and of GRID, up to 2.4 in
        blurred clips.
    turn_speed : float, rad/s
        Standard deviation of how fast a head turns about each axis in such frames. Chosen of 0.35,
        0.7 and none on p01 to p08 of the strangers' clips, by how many frames' rotation is more
        than 1.5 degrees off the middle of those beside them: 67, 76 and 105 of 778, and 71 with
        0.35 since the frame before counts as surely as it is known. Of the tremor of ICT's heads
        (`tests/ict_films.py --tremor`) 0.98 is found then, and 0.93 where clear frames lean on
        those before, too, even with 1.4.
    turn_stray : float, standard deviations
        Of a turn from one frame to the next, beyond which it counts less (Cauchy). Not measured.
    pose_floor : tuple of float, rad and mm
        How far a pose is off at best: the head's shape is not quite the person's. Not measured.
    """

    pupil_noise: float = 0.6
    pixel_noise: float = 0.5
    landmarks_alike: float = 8.0
    rounds: int = 2
    known_rounds: int = 3
    first_steps: int = 8
    steps: int = 3
    frame_steps: int = 5
    frame_settled: float = 3e-3
    start_settled: float = 0.03
    settled: float = 1e-3
    identity_counts: float = 0.1
    near: int = 3
    known_near: int = 5
    joint_alike: float = 4.0
    most_turn: float = 0.4
    scale_held: float = 0.5
    given_held: float = 0.1
    eyes_unseen: float = 0.08
    given_apart: float = 8.0
    given_away: float = 25.0
    given_origin: float = 30.0
    given_deviation: tuple[float, ...] = (0.005, 0.005, 0.005, 0.17, 0.17, 1.33)
    given_step: tuple[float, ...] = (0.1, 10.0, 10.0, 10.0)
    side: int = 320
    margin: float = 4.0
    shading: int = 13
    most_points: int = 120
    least_apart: float = 3.0
    least_points: int = 8
    facing: float = 0.25
    levels: int = 2
    returns: float = 0.7
    flow_reach: float = 12.0
    still: float = 1.5
    above: float = 12.0
    scalp: float = 130.0
    front: float = 20.0
    most_slide: float = 8.0
    grazing: float = -0.15
    match_noise: float = 0.5
    matches_alike: float = 4.0
    gaze: tuple[float, ...] = (3.0, 2.0)
    clear: float = 1.0
    turn_speed: float = 0.35
    turn_stray: float = 2.0
    pose_floor: tuple[float, ...] = (0.006, 0.006, 0.006, 0.3, 0.3, 2.0)


HEAD_POSE = HeadSettings()
