"""Settings of finding faces, and of following the chosen one."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class DetectionSettings:
    """Settings of finding faces, and of following the chosen one.

    Attributes
    ----------
    sure : float, probability
        Of a face in the whole picture at least. Measured: of faces that were tried it is 0.66 and
        more, most of them 0.9, and of what is none up to 0.6 (but for a cat's).
    surer : float, probability
        The same in parts of the picture, of which more are looked at. Not measured.
    upright : float, probability
        From which on a face is not looked for in the turned picture, too. Measured: upside down at
        most 0.75 on p01 to p16 of the strangers and 0.83 on the bundled people; on its side a face
        may have as much, and is then marked right.
    plainly_turned : float, probability
        By which a face must be surer in the turned picture. Measured: 0.09 (p12) and more, of most
        faces 0.2.
    little : int, px
        Longer side of the picture that is turned: twice what the detector sees. Not measured.
    same : float, overlap over union
        Of two guesses, from which on they are of one face. Not measured.
    again : float, sides of the face's box
        That are looked at once more, to place its points better. Not measured.
    least_apart : float, sides of its square
        That a face's eyes are apart at least. Not measured.
    smaller : tuple of float, shorter sides of the picture
        Parts of it that are looked at if there is no face. Not measured.
    apart : float, face heights
        Farther off, a face is another one. Not measured.
    size_ratio : float, ratio
        Of sizes, beyond which a face is another one. Not measured.
    widening : float, share
        By which both grow with each frame that the face is lost. Not measured.
    most_size_ratio : float, ratio
        To which the second grows at most. Not measured.
    of_box : float, sides of the detector's square
        Height of a face's landmarks. Not measured.
    doubtful : float, `Landmarks.unlike`
        From which on the detector is asked where the face is. The network is as sure of points
        beside a face that has moved fast, but in the mirror image it puts these elsewhere.
        Measured: on faces at most 0.030 (p01 to p08 of the strangers' clips, one frame; 0.034 in a
        near profile, p11), on points beside one up to 0.11.
    wrong : float, `Landmarks.unlike`
        From which on there is no face. Measured with `doubtful`.
    faces_kept : int, frames
        Whose landmarks are remembered. A bound on memory. Not measured.
    patience : int, frames
        Without the face that is followed, after which any face is taken. Not measured.
    settled : int, frames
        In a row with a face, after a cut, from which on it is the one that is followed: the first
        may be cut off by the picture's border. Not measured.
    looks_every : int, frames
        After which the followed face's look is taken, and others near it are looked for. Not
        measured.
    rival_reach : float, face heights
        Within which they are: who passes by 0.15 of them a frame is seen in time. Not measured.
    look_side : float, px
        Height of a face at which its colours are compared with another's. Not measured.
    taken : float, ratio
        Of a face's differences from the look of one nearby and from that of the followed one, below
        which it is the one nearby. Measured on p01 to p08 of the strangers' clips: looks of one
        person differ by 0.02 to 0.14 from one time to the next (median), those of two by 0.19 to
        0.58.
    same_look : float, logarithm of colours
        Difference of two looks below which they are of one person. Measured with `taken`: looks of
        two people differ by 0.16 at least.
    cut_cells : int, cells to a side
        Of the coarse picture by which cuts are found. Not measured.
    cut_side : int, px
        Least side that a picture is thinned to before these are averaged. A bound on time.
    cut_dark : float, levels of 255
        That are added to their brightness, so that noise in the dark is none. Not measured.
    plain : float, levels of 255
        Standard deviation of a coarse picture's cells, below which a picture is plain. Not
        measured.
    change : float, standard deviations
        Of a coarse picture's cells, from which on a cell has changed between two frames. Not
        measured.
    most_changed : float, share of the cells
        Above which there is a cut between two frames. Measured: at most 0.31 from frame to frame of
        strangers' and GRID's clips; between any two of these clips 528 of 552 cuts are found (506
        without the logarithm and the plane), and 23 of 24 where a picture is enlarged by 1.4.
    most_shifted : float, share of the picture
        By which a camera moves it, at most, between two frames of one shot. Not measured.
    most_changed_shifted : float, share of the cells
        The same as `most_changed` once two frames are laid over each other by the best shift.
        Measured: as many cuts between clips are found; in p09 to p16 of the strangers' clips,
        shaken by 14, 20 or 28 px of 360 a frame, none is seen where there is none (264 in 1,416
        without); in p01 to p08 18 (137).
    least_face : float, px
        Of a face; of a smaller one a picture shows nothing. Not measured.
    narrowest : int, px
        Shorter side of a picture, at least, in which a face is looked for. Not measured.
    longest : float, times its width
        Of such a picture at most. Not measured.
    present : float, probability
        Of a face by the landmark network at least. Measured: 0.94 and more of faces, at most 0.74
        beside one.
    turned_eyes : float, ratio
        Of the widths of both eyes, below which the head is turned too far for its pupils. Not
        measured.
    shut_eye : float, ratio
        Of an eye's height and width, below which its iris is guessed. Not measured.
    least_eye : float, px
        Width of an eye, below which its iris is guessed, too. Not measured.
    cut_margin : float, sizes of the face
        From a border that cuts a face off, within which landmarks are trusted less where it is
        asked whether the mouth lies in the picture. Measured on p01 to p08 of the strangers' clips,
        cut off at several heights: landmarks are seen off by 0.04 to 0.05 of the face's size within
        0.1 of the border, by 0.03 at 0.15, 0.01 from 0.3 on.
    eyes_inside : float, sizes of the face
        From such a border to the eyes at least. Chosen on p01 to p08 of the strangers' clips: eyes
        that lie outside are seen up to 0.05 within the picture, but in one frame of a hundred.
    reach : float, mm
        Across the line of sight: farther a head does not get from frame to frame. Not measured.
    alike : float, correlation
        Of a face with itself a frame later at least. Measured: 0.9 and more, 0.8 in a blink; 0.3
        with another person, or nearer by a quarter.
    least_template : int, px
        Across a template; less shows nothing. Not measured.
    most_template : int, px
        Across a template, at which it is compared. Not measured.
    box_width : float, mm
        Of the square around a face by which a box around its mouth is enlarged. Chosen or measured
        on GRID's clips.
    mouth_height : float, share of that square
        That the mouth's middle lies below its top. Not measured.
    mouth_width : float, share of that square
        That the mouth is wide. Not measured.
    eyes_apart : float, mm
        Between the middles of the eyes. Chosen between 63 in people (Dodgson 2004), 65 in the ICT
        face model's mean and 60 in the bundled average person, whose mouth is as much too narrow.
    given_spread : float, mm
        Standard deviation of a pupil distance that somebody measured. Not measured.
    pole : float, share of an eye's depth
        What lies so near to its foremost point is its pupil. Not measured.
    seen_at : tuple of tuple of float, mm
        Where the detector sees eyes, tip of the nose and mouth, less the landmarks. Not measured.
    mark_deviation : tuple of tuple of float, mm
        Across and down a face, how far people's marks differ from the average head's. Not measured.
    turn_deviation : tuple of float, rad
        Pitch, yaw, and roll beyond the eyes'. Not measured.
    """

    sure: float = 0.6
    surer: float = 0.75
    upright: float = 0.88
    plainly_turned: float = 0.08
    little: int = 256
    same: float = 0.3
    again: float = 1.6
    least_apart: float = 0.05
    smaller: tuple[float, ...] = (1.0, 0.5)
    apart: float = 0.75
    size_ratio: float = 1.5
    widening: float = 0.03
    most_size_ratio: float = 3.0
    of_box: float = 1.35
    doubtful: float = 0.03
    wrong: float = 0.05
    faces_kept: int = 500
    patience: int = 50
    settled: int = 5
    looks_every: int = 10
    rival_reach: float = 2.5
    look_side: float = 24.0
    taken: float = 0.7
    same_look: float = 0.12
    cut_cells: int = 16
    cut_side: int = 128
    cut_dark: float = 8.0
    plain: float = 6.0
    change: float = 0.35
    most_changed: float = 0.5
    most_shifted: float = 0.25
    most_changed_shifted: float = 0.35
    least_face: float = 8.0
    narrowest: int = 16
    longest: float = 8.0
    present: float = 0.8
    turned_eyes: float = 0.5
    shut_eye: float = 0.12
    least_eye: float = 2.0
    cut_margin: float = 0.2
    eyes_inside: float = 0.055
    reach: float = 60.0
    alike: float = 0.7
    least_template: int = 12
    most_template: int = 96
    box_width: float = 175.0
    mouth_height: float = 0.805
    mouth_width: float = 0.27
    eyes_apart: float = 62.0
    given_spread: float = 0.5
    pole: float = 0.03
    seen_at: tuple[tuple[float, ...], ...] = (
        (0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0),
        (0.0, -3.0, 0.0),
        (0.0, -0.9, 0.0),
    )
    mark_deviation: tuple[tuple[float, ...], ...] = ((1.8, 3.0), (1.8, 3.0), (1.5, 6.0), (1.5, 6.0))
    turn_deviation: tuple[float, ...] = (0.1, 0.4, 0.1)


DETECTION = DetectionSettings()
