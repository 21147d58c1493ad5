"""Settings of doubts: what a run warns of, and which recordings are of one speaker."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class DoubtSettings:
    """Settings of doubts: what a run warns of, and which recordings are of one speaker.

    Attributes
    ----------
    least_separability : float, probability
        That a pixel of skin or lips is classified right, below which a run warns that colours say
        little of lips. Not measured.
    least_agreement : float, slope
        Of apertures by colours alone with those by landmarks, below which a run warns. Measured on
        p01 to p08 of the strangers' clips: six have 0.76 and more; two, which are right all the
        same, 0.60 and less.
    least_score : float, share
        Mean of the picture that the colours of a drawn mouth explain, below which a run warns.
        Measured: runs that were right had 0.86 and more.
    least_face_score : float, share
        The same of a speaker's own face, by texture or local evidence. Measured: its own speaker's
        runs have 0.94, another's 0.64 to 0.88.
    least_talking_score : float, share
        The same of a talking face. Chosen with the faces of three bundled people, tracked in 25
        frames: in films in the light of their pictures they explain 0.92 to 0.98 of their own
        person; in other light, smaller or more compressed, 0.75 to 0.94 in five of six runs, and
        0.39 in one, whose apertures are 9 mm off (in the five 1.6 to 3.4). Of other people, bundled
        or in GRID, 0.47 to 0.95: less than 0.7 in three of ten clips by local appearance, in two
        of two by textures. Above it another face is not distinguished from other light.
    longest_closed : float, s
        That lips stay closed in speech: a run warns if they do in all tracked frames of more.
        Measured: in runs of eight clips of GRID and p01 to p16 of the strangers at most 1.93.
    least_mouth : float, px
        Width of the mouth, in the median frame, below which a run warns of it alone, and not of
        colours that disagree with landmarks. Measured with one clip of GRID scaled down: apertures
        follow those of the full size with r = 0.95 at 12 pixels, 0.50 at 6, 0.45 at 4. The smallest
        of p01 to p16 of the strangers' clips is 17.
    face_height : float, mm
        Of a usual face, by which it is judged how much of it the picture can hold. Not measured.
    face_width : float, times its height
        Of a usual face. Not measured.
    most_face : float, times the picture's height or width
        Height or width of the face in the median frame, above which a run without --worn warns of a
        close-up. Chosen by heights, on a close-up of `tal_lips`, 1.25, and clips of GRID of 0.46 to
        0.57, also cut: below the nose, 0.69 to 0.80, and above the mouth, without the eyes, 1.04 to
        1.22.
    most_held : float, share of the frames
        Held to the landmarks, above which a run warns. Not measured.
    most_lost : float, share of the frames
        Lost, above which a run warns. Not measured.
    mouth_away : float, heights of the face
        Between the middles of the drawn mouth and of the one that the landmark network sees, above
        which it lies elsewhere. Chosen with `mouth_sizes` on runs of p01 to p08 of the strangers
        with `--start blobs`, and of p02 and p05 with another person's talking face, all looked at:
        0.03 at most of mouths that are right, 0.04 to 0.07 of those of others.
    mouth_sizes : tuple of float, times
        Size of the drawn mouth over that of the one that is seen, below and above which it is
        another. Chosen on the same: 0.83 to 1.11 of mouths that are right, 0.6 to 0.86 and 1.5 to
        1.8 of two that are not.
    parted : float, distances of the eyes' outer corners
        Height between the inner lips, above which the landmark network sees an open mouth. Chosen
        on the same: 0.002 at most where lips are closed, also in runs by landmarks; where they are
        not, but are drawn closed, 0.07 to 0.2. In p09 to p16 0.03 at most and 0.05 to 0.17.
    openness_mm : float, mm
        Aperture that goes with an openness of 1 in distances of the eyes' outer corners. Measured
        in three runs with learned lips, drawn and filmed: standard deviations of both have ratios
        of 105, 111 and 128.
    openness_varies : float, standard deviation
        Of openness, from which on lips are seen to open and close. Measured in the same: 0.029 to
        0.041.
    least_following : float, share
        Of how apertures of learned lips vary, over how they should by openness, below which a run
        warns. Measured: 0.95 and more in the same; 0.00 with lips that were learned of a mouth that
        stays as it is, open or closed.
    fewest_looks : int, frames
        For that warning. Not measured; a clip of three seconds has 8.
    look_apart : float, s
        From one frame that is looked at for these to the next. Not measured.
    looks : int, frames
        After which they lie twice as far apart. Not measured.
    face_square : float, mm
        Side of a face as the detector sees it. Measured: 135 to 201, mostly 158 to 187, in 48
        frames of the strangers' clips.
    face_proportions : tuple of float, times those of the bundled head
        Least and most width of a face for its height; beyond, a run warns that the video may be
        stretched. Chosen on p01 to p08 of the strangers: 0.92 to 1.13 as they are; made wider by a
        third, all eight are warned of, made narrower by a quarter, seven. Measured on p09 to p16:
        0.95 to 1.12, seven, five; on GRID's clips and 16 films of other heads 0.91 to 1.12.
    face_proportion : float, times its height
        Width of the bundled head's face. Measured on it.
    larger_face : float, times that of the followed face
        Size of another from which on a run warns. Not measured.
    most_others : float, share of the frames looked at
        With such a face, or with another one alone, from which on a run warns. Not measured.
    mouth_down : float, share of `face_square`
        From its top to the mouth. Not measured.
    still_cells : int, cells to a side
        Of the coarse picture by which a face that never moves is found. Not measured.
    still_changed : int, cells
        That change most, of which the mean counts. Not measured.
    still_change : float, share of the face's brightness
        Below which these change in a still picture. Measured: up to 0.06 over 100 frames of nine
        stills with noise of 6 levels; at least 0.18 over any 40 frames of strangers' and GRID's
        clips.
    still_frames : int, frames
        That a face must be seen in at least, at any rate. Not measured.
    still_seconds : float, s
        That a face must be seen for, as people may rest. Measured: ten frames of them change by as
        little as 0.02.
    most_elsewhere : float, share of the frames looked at that show a face
        Above which a run warns. Not measured.
    most_speaker_misfit : float, standard deviations
        Of landmarks from the head of a speaker's face, above which a run warns, and looks are
        learned from the clip: median of frames in the first second. Chosen with two faces, each of
        three clips of GRID's s1: in 40 clips of s1 it is 0.50 to 1.10, in p01 to p08 of the
        strangers 2.01 to 3.89. Measured on p09 to p16, 2.3 and more, and on seven other speakers of
        GRID, 1.42 to 2.83: with one of the two faces, one of them is not noticed.
    landmark_unsure : float, mm
        Standard deviation of an aperture by landmarks. Not measured.
    landmark_share : float, share of the aperture
        That is added to it in quadrature. Not measured.
    most_contradicted : float, share of the frames
        Contradicted, above which a run warns. Measured on p01 to p08 of the strangers' clips: 0.22
        in the one where teeth are taken for lips; in the others, and in eight clips of GRID, 0.12
        and less.
    less_explained : float, share of the picture about the mouth
        By which a frame falls short of what is explained of its clip's median one, from which on
        it is marked. Chosen on p01 to p08 of the strangers, as they are and with a word written
        over the lower lip in some frames: of these 71 % are marked, of the bare ones beside them 3
        %. Measured on p09 to p16: 93 (4 more are lost) and 0.5 %.
    most_less_explained : float, share of the frames
        So marked, above which a run warns. Chosen on the same: of p01 to p08 as they are, two are
        warned of, one that shouts and one that turns fast. Measured: one of p09 to p16, that turns
        fast.
    fewest : int, frames
        For any of these warnings. Not measured.
    speaker_open : float, mm
        A mouth that is open, in some frame at least of what a speaker's face is learned from. Not
        measured.
    speaker_closed : float, mm
        The same of a closed one. Not measured.
    same_speaker : tuple of float, mm
        RMS over the face from which on a head is another person's, without what its height and
        depth change alike, and of the whole: see `check_same`. Chosen on heads of two halves of a
        clip: up to 0.6 and 1.2 in eight speakers of GRID, 2.2 and 4.0 in p01 to p08 of the
        strangers, who change their expressions. Measured on p09 to p16: up to 2.1 and 2.9. Of 552
        pairs of two people 0.87 differ by more, of 575 of their whole clips 0.73.
    doubted_speaker : tuple of float, mm
        The same from which on `speaker` warns. The first was chosen on 12 strangers and 7 clips of
        one person (s1 of GRID): up to 0.85 within the person, 1.47 and more between people.
        Measured on the other 11 and 7: up to 1.16, and 1.37 and more. What is left out was chosen
        with all of them in view. One clip of a person differs from itself by 0.9 to 2.1 in grey, by
        1.9 darker, by 1.6 in noise. The second: of 40 clips of s1 up to 2.1 from each other.
    """

    least_separability: float = 0.75
    least_agreement: float = 0.7
    least_score: float = 0.78
    least_face_score: float = 0.8
    least_talking_score: float = 0.7
    longest_closed: float = 2.5
    least_mouth: float = 10.0
    face_height: float = 200.0
    face_width: float = 0.72
    most_face: float = 1.15
    most_held: float = 0.1
    most_lost: float = 0.5
    mouth_away: float = 0.04
    mouth_sizes: tuple[float, float] = (0.75, 1.3)
    parted: float = 0.04
    openness_mm: float = 110.0
    openness_varies: float = 0.02
    least_following: float = 0.3
    fewest_looks: int = 5
    look_apart: float = 0.4
    looks: int = 8
    face_square: float = 175.0
    face_proportions: tuple[float, float] = (0.88, 1.18)
    face_proportion: float = 1.4306
    larger_face: float = 1.5
    most_others: float = 0.3
    mouth_down: float = 0.7
    still_cells: int = 16
    still_changed: int = 8
    still_change: float = 0.08
    still_frames: int = 10
    still_seconds: float = 2.0
    most_elsewhere: float = 0.5
    most_speaker_misfit: float = 1.5
    landmark_unsure: float = 0.8
    landmark_share: float = 0.15
    most_contradicted: float = 0.15
    less_explained: float = 0.06
    most_less_explained: float = 0.1
    fewest: int = 10
    speaker_open: float = 5.0
    speaker_closed: float = 1.5
    same_speaker: tuple[float, float] = (2.3, 4.5)
    doubted_speaker: tuple[float, float] = (1.2, 2.2)


DOUBTS = DoubtSettings()
