"""Settings of the preparation of a clip: whose mouth it is, and where."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class PreparationSettings:
    """Settings of the preparation of a clip: whose mouth it is, and where.

    Attributes
    ----------
    learn_from : int, frames
        That a clip's colours and person are learned from. Not measured.
    look_at : int, frames
        From the first one with a face, that these are chosen from. A bound on time. Not measured.
    least_found : float, share of the frames looked at
        With a face; with fewer there is nothing to learn from. Not measured.
    view_rounds : tuple of tuple of float, half windows and share
        How unsure the place is in each round, in halves of a window's width, and of where lips are
        drawn, how much may be the mouth's inside: the posture may be wrong, and what is drawn
        closed would stay so; less and less so. In the first, only a known head's colours are
        learned by it. Chosen on clips with teeth in the shade of lips that rest parted, which need
        much of it in all rounds (with 0.35 in the last, what such a clip came to hung on where it
        was begun), and on full lips, whose shade needs little in the last (with 0.65 one closure in
        ten was missed).
    placed : float, probability
        Most that a place alone says of what is seen there. Not measured.
    searched : float, standard deviations
        To either side, how far the mouth is looked for. Not measured.
    search_steps : tuple of float, mm
        From place to place where the mouth is looked for, across and down. Not measured.
    search_depths : tuple of float, standard deviations
        Of the depth, that are tried there. Not measured.
    elsewhere : float, mm
        A face that is farther off is another face's, or none's. Not measured.
    elsewhere_depth : float, share of the depth
        The same in depth. Not measured.
    searched_more : tuple of float, mouth widths
        That the searched window is wider and higher by than the one that is fitted. Not measured.
    frames_together : float, frames
        That all of them count as: a place that is wrong is wrong in each. Not measured.
    between_lips : float, mouth widths
        Over which one lip's colours turn into the other's. Not measured.
    place_margin : float, mm
        From the outline of the lips, where a side is sure. Not measured.
    place_softness : float, mm
        How softly that begins. Not measured.
    sure_within : float, probability
        Most that a place alone says within the lips: no skin is seen there, but teeth in shade may
        look so. Not measured.
    sure_beyond : float, probability
        The same beyond them: lips may still be there where landmarks are wrong, and colours twenty
        times likelier win. Not measured.
    strange : float, share of the pixels
        That show none of the classes, as hair or a collar: any colour alike. Not measured.
    depth_frames : int, frames
        Evenly spread, that each depth is tried on. Not measured.
    depths : tuple of tuple of float, share of the depth
        That are tried about the one before, in the first rounds. Not measured.
    good_score : float, share of the mouth's window
        That a calibration explains, below which fuller lips and a lower start are tried. Measured
        on clips that were followed: 0.86 and more; with the upper lip missed in a smile 0.8; with
        the mouth missed 0.64.
    poor_score : float, share of the mouth's window
        Below which nearer and farther starts are tried. Measured with `good_score`.
    higher : tuple of float, mm down and share of the depth
        Where else to begin in any case. The shade below a lower lip is taken for lip, and so are
        teeth in shade behind parted lips: the mouth that is fitted drifts down to where both are
        explained. Begun higher it does less often. Chosen or measured on GRID's clips.
    lower : tuple of float, mm down and share of the depth
        Where else to begin if that is not good. Not measured.
    fuller_upper_lip, fuller_lower_lip : float, standard deviations
        With what lips a calibration begins, too, if it is not good: the lower one of full lips that
        catches the light is else taken for skin, and learned so. Not measured.
    nearer_and_farther : tuple of tuple of float, mm down and share of the depth
        And if it is poor. Not measured.
    darkest : float, of 255
        Mean brightness of frames without a face below which that is said of them. Chosen with a
        clip of GRID, darkened: its face is found at 7, and not at 1.5.
    brightest : float, of 255
        The same above which it is said. Not measured.
    least_shown : int, frames
        With a mouth to be seen, from which on those in which it is hidden are left out. Not
        measured.
    mouth_apart : float, logarithm
        By how much the colours of a mouth differ, beside the forehead's, from one group of frames
        to the next, at least, where something hides it in one of them. Chosen on p01 to p08 of the
        strangers behind painted masks and microphones (`tests/hidden_clips.py`): bare frames lie at
        most 0.32 apart, and at least 0.92 from the others. Measured on p09 to p16: 0.35 and 1.3;
        hands of the speaker's own skin are 0.07 to 0.96 away, so that half of them are found.
    hidden_rounds : int, times
        That they are left out, and the person is fitted again, at most: what was learned with them
        may take the mouth itself for hidden. Not measured.
    person_spread : float, share of how far people differ
        How far a mouth may differ from that of a head fitted to landmarks. Chosen of 0.35, 0.5 and
        0.7 on edges of lips that were read by eye in p01 to p08 of the strangers' clips: inner
        edges of parted lips lie 0.7 and 0.4, 0.7 and 0.3, 0.6 and 0.2 mm too low, outer ones are
        alike, and median r of apertures with the gap that was read is 0.979, 0.980 and 0.980 (in
        p09 to p16 0.970, 0.983 and 0.983). With 0.7 closed lips came out parted in a film whose
        light falls (`tests/tracking/detection/test_light.py`).
    placed_opening : float, mm
        From where lips meet, how far a mouth may be open that is drawn closed. Not measured.
    placed_inside : float, share of where lips are drawn
        That may be the mouth's inside, as the posture may err. Not measured.
    posture_limit : int, evaluations
        Of a posture's fit at most. Not measured.
    joint_tolerance : float, nats
        By less than which the values of a simplex over person and place differ when it stops. Not
        measured.
    joint_limit : int, evaluations
        Of that simplex at most. Not measured.
    reaches_again : tuple of int, drawn pixels
        To either side of a border that are looked at when a posture is fitted again, once the
        person has moved. Measured with this and without the simplex, on all strangers' clips and
        GRID: r and closures are as with all reaches and eight evaluations of the simplex.
    speaker_looked : int, frames
        From the first one with a face on, in some of which the head in a clip is compared with that
        of a speaker's face. Not measured.
    speaker_views : int, frames
        That are kept to place a speaker's head by, those that face most differently. Not measured.
    speaker_least_each : int, frames
        Of each recording at least, that a speaker's mouth and colours are fitted to. Not measured.
    speaker_most : int, frames
        Of all recordings at most, unless `speaker_least_each` makes them more. Not measured.
    speaker_turned : int, frames
        Of all recordings together, about, and one of each at least, that a speaker's head is fitted
        to: landmarks of many frames err alike, and would outweigh what is known of people. Chosen
        on a clip of a person drawn by chance, tracked with anybody's postures: lips are 1.26 mm off
        with 15, 1.44 with 30, and 1.70 with 30 that are spread over postures.
    seen_deviation : tuple of float, rad, mm and share of the depth
        What the faces found in several frames leave open of the mouth's place, the last by which
        the distances of people's eyes differ. Not measured.
    given_deviation : tuple of float, rad, mm and share of the depth
        The same of a place that somebody gave, or where no face was found again. Not measured.
    aligned_deviation : tuple of float, rad and mm
        What is left where the head's texture was aligned. Not measured.
    pose_deviation : tuple of float, rad and mm
        What the rigid motion of the upper face leaves open in a frame. Measured on films of unknown
        ICT heads (seeds 5 to 8; 61 to 64), 0.15 mm for 0.5 across the line of sight: the lips'
        motion is off by 1.08 and 0.88 mm for 1.10 and 0.89, apertures are alike, and 90 % intervals
        hold 0.92 and 0.85 of the gaps read by eye in strangers' mouths (two halves) for 0.93 and
        0.88. With a third of the rotation, too, 0.89 of the closed frames of seed 7 are found for
        0.96.
    """

    learn_from: int = 8
    look_at: int = 250
    least_found: float = 0.1
    view_rounds: tuple[tuple[float, float], ...] = (
        (0.16, 0.6),
        (0.08, 0.55),
        (0.05, 0.5),
        (0.04, 0.45),
    )
    placed: float = 0.95
    searched: float = 4.0
    search_steps: tuple[float, float] = (4.0, 3.0)
    search_depths: tuple[float, ...] = (-1.2, -0.6, 0.0, 0.6, 1.2)
    elsewhere: float = 60.0
    elsewhere_depth: float = 0.35
    searched_more: tuple[float, float] = (0.8, 1.6)
    frames_together: float = 2.0
    between_lips: float = 0.02
    place_margin: float = 2.0
    place_softness: float = 0.7
    sure_within: float = 0.998
    sure_beyond: float = 0.95
    strange: float = 0.02
    depth_frames: int = 4
    depths: tuple[tuple[float, ...], ...] = (
        (-0.07, -0.035, 0.0, 0.035, 0.07),
        (-0.03, 0.0, 0.03),
        (-0.015, 0.0, 0.015),
    )
    good_score: float = 0.85
    poor_score: float = 0.8
    higher: tuple[float, float] = (-12.0, 0.0)
    lower: tuple[float, float] = (12.0, 0.0)
    fuller_upper_lip: float = 1.0
    fuller_lower_lip: float = 1.5
    nearer_and_farther: tuple[tuple[float, float], ...] = ((0.0, -0.15), (0.0, 0.15))
    darkest: float = 10.0
    brightest: float = 245.0
    least_shown: int = 3
    mouth_apart: float = 0.5
    hidden_rounds: int = 2
    person_spread: float = 0.5
    placed_opening: float = 2.5
    placed_inside: float = 0.6
    posture_limit: int = 60
    joint_tolerance: float = 0.1
    joint_limit: int = 500
    reaches_again: tuple[int, ...] = (3, 2, 2)
    speaker_looked: int = 25
    speaker_views: int = 12
    speaker_least_each: int = 2
    speaker_most: int = 32
    speaker_turned: int = 15
    seen_deviation: tuple[float, ...] = (0.05, 0.03, 0.02, 2.0, 3.0, 0.06)
    given_deviation: tuple[float, ...] = (0.06, 0.05, 0.04, 4.0, 5.0, 0.08)
    aligned_deviation: tuple[float, ...] = (0.03, 0.02, 0.01, 1.0, 1.0, 10.0)
    pose_deviation: tuple[float, ...] = (0.015, 0.015, 0.015, 0.5, 0.5, 4.0)


PREPARATION = PreparationSettings()
