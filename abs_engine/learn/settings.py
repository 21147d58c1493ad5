"""Settings of learning: faces, and how they move."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class LearningSettings:
    """Settings of learning how lips and faces move, from dots, points, videos and labels.

    Attributes
    ----------
    jump : float, mm
        That a dot may be off the modes of the dots in any case. Not measured.
    far_off : float, standard deviations
        From the frames' median, beyond which a dot that is farther off the modes than `jump` is not
        believed. Not measured.
    fewest_dots : int
        Of a frame that is learned from: half of the lips'. Not measured.
    dot_modes : int
        By which dots are believed at most. Not measured.
    dot_rounds : int
        In which they are found. Not measured.
    dot_noise : float, mm
        Noise of exact dots. Not measured.
    hiding : float, mm
        Before a dot, from where on something may hide it; the dot's own facets do not. Not
        measured.
    highest_bead : float, mm, head frame
        No bead is higher: below the eyes, where speech moves the face. Not measured.
    facing_dot : float, part of a vertex's normal
        That must point forward at least where a dot for two cameras is put. Not measured.
    dots_apart, beads_apart : float, mm
        Least distance of such dots, near the mouth and on the rest of the face. Not measured.
    corner : float, mm
        Beads within this height of the mouth's corners are above neither lip nor below it. Not
        measured.
    teeth_beads : tuple of float, mm
        Across, where beads on the lower teeth are. Not measured.
    ring_beads : int, beads
        Around the lips. Not measured.
    ring_away : float, mm
        From the lips' border to these. Not measured.
    farthest_dots : float, mm RMS
        That mean dots may be from where they are on the head at rest. Measured: 4 of a person who
        speaks, 8 and more of most others.
    exchanged : float, share of the mean dots' distance from the average head's
        What is left if two dots are exchanged, below which their names are taken to be exchanged.
        Measured on the bundled people, who speak, open or round their mouths or smile on one side,
        marked to 2 mm: 0.92 and more is left with right names; with two exchanged, less is left for
        118 of 120 pairs if they speak, for 107 if marked to 2 mm. Dots of the others lie close.
        Of 406 that were exchanged in one of two views, which agree on them even so, 397 are named,
        with the view.
    flattest : float, share of their width
        That mean dots at least extend across their best plane, RMS each. Measured: the bundled
        people have 0.13 to 0.27.
    steepest : float, degrees
        By which dots may be turned from the head frame. Measured: up to 17 for the bundled people,
        whose lips slope differently.
    mouth_sizes : tuple of float, times that of the head
        Of a mouth, least and largest. Measured: the bundled people who speak have 1.0 to 1.3.
    further_rounds : int
        Of settling frames and learning from them. Not measured.
    strained : float, mm
        By which nodes typically leave the modal shape. Chosen on clara's clips: with 0.4 errors of
        1.00 mm, with 0.8 of 0.94.
    free_modes : int
        That the relaxed shell has. Chosen on clara's clips, where more do the same.
    starts : int
        Postures that a frame begins at, at most. Not measured.
    left_out : float, share of a clip
        Its end, that nothing is learned from: faces are compared on it. Not measured.
    blocks : int
        Of time that are left out in turn: of the 140 frames at 30 Hz that the paper learns from,
        two thirds of a second each, so that a posture is left out together with the way into it.
        Not measured.
    most_noise : float, share of a component's variance
        That may be noise; with more it is left out. Not measured.
    resting : float, share of the frames
        Those in which the mouth moves least, from which the noise is measured. Not measured.
    least_resting : int, frames
        Of them at least, where there are so many. Not measured.
    worse : float, probability
        How much worse a speaker's own postures may explain left-out frames than anybody's and still
        be kept. Measured: in two people, drawn or filmed, they differ by at most 0.001; where fast
        speech was taken for noise, by 0.03.
    beyond : float, standard deviations
        Beyond what was seen, to which a fit may go. Not measured.
    sudden : float, times its usual step
        That a posture may move between two frames: speech is not even. Not measured.
    most_seen : int, postures
        That are kept. Not measured.
    least_frames : int, frames
        That a speaker's own postures are learned from; of fewer, anybody's are kept. Five sentences
        of GRID's s1, that are enough, have 300, of which some are doubted. Chosen on halves of p02,
        p04, p05 and p07 of the strangers: of the 40 to 48 frames in the first, own postures explain
        its end as well, but in the second half a smile is not followed, half the frames of one clip
        are lost, and three of six closures of another are missed. Measured on p09, p10, p14 and
        p16: widths follow the landmark detector's with r = 0.37 in the mean, with anybody's 0.75,
        and three of six closures of one clip are missed, with anybody's none.
    spacing : float, mm
        Between the points of local appearance at least. Not measured.
    coarse : float, px per mm
        Of a speaker's texture, at most: between recordings a frame's texture is worth a dozen of
        independent observations, and finer ones only take longer. Not measured.
    finest : float, drawn pixels per mm
        Of local appearance at most: its filters are to reach 2 mm and more, or a fit that starts
        far away does not come home. Not measured.
    modes : int
        The paper's ten, of section 4.2.
    trained : int, frames
        The paper's first 140, of section 4.2.
    least_moved : float, mm RMS
        Of the dots' distances from their mean places, below which lips do not move. Measured: 3.9
        to 4.6 of six bundled people who speak; up to 0.4 in those tenths of a recorded range of
        motion, of 140 frames each, in which the mouth moves least, and 1.7 in a quarter of them.
    frames_a_mode : int, frames
        For each mode at least: with hardly more frames than modes these hold all the frames
        exactly, errors of observation too, and would pass for exact. Not measured.
    least_articulated : float, mm RMS
        Of the distance of the point that moves most from its mean place over the visemes of a
        corpus, below which nothing moves. Measured: 7.2 of bundled people, 4.0 and more of any 8 of
        their visemes.
    most_built : int, models
        That are built to measure visemes that were not learned: of more visemes several are left
        out at once. A bound on time.
    still : float, mm
        By which the corpus moves at most what counts as still. Not measured.
    near : float, mm
        From a measured point, what moves with it. Not measured.
    bite_width : float, mm
        To both sides of the middle of the upper teeth, in which their front edge lies. Not
        measured.
    blink : float, weight
        Of lids that close: what lids and brows move is not `still`, and is not compared. Not
        measured.
    brow : float, weight
        Of brows that move, likewise. Not measured.
    opening_pixels : int, pixels
        Of a picture that openings are learned from. Not measured.
    opening_copies : int, pictures
        Of a frame, besides mirrored ones. Not measured.
    opening_near : float, px
        About the inner lips that most of these pixels lie within. Not measured.
    opening_varied : float, standard deviation of the share near the inner lips that is inside
        By which a mouth must move for a model's disagreement with it. Chosen on p01 to p08 and
        eight speakers of labelled close-ups (0.047 and more). Measured on p09 to p16: 0.07 and
        more, but for p13, a smile that hardly moves (0.02).
    opening_anywhere : float, share of these pixels
        That lie elsewhere. Not measured.
    opening_reach : float, px
        Above and below the corners that are learned from. Not measured.
    opening_off : tuple of float, mouth widths and rad
        Standard deviations of the place, across and down, the size (in logarithm) and the roll by
        which mouths are put off, as they are not found exactly. Not measured.
    opening_frames : int, frames
        Labelled, below which `mouths` warns. Chosen: what is measured was learned from 63 labelled
        frames of nine people; fewer were not measured.
    opening_videos : int, videos
        Labelled, below which it warns, as they cannot show as many people. Chosen likewise.
    opening_parted : float, mouth widths
        Between an upper and a lower point of the inner lips, above which a label is of an open
        mouth. Measured in 74 labels of ten people: 0.015 and less in the 20 that are closed, 0.04
        and more in the others; each person has both.
    network_hidden : int
        Units of a hidden layer. Decided after a look at all ten speakers of the TaL corpus; not
        measured.
    network_epochs : int
        Of training. Not measured.
    network_batch : int, pixels
        Of a step of training. Not measured.
    network_rate : float, per step
        Of training. Not measured.
    network_last : float, share
        Of the first rate of training, with which it ends; in between it falls as a cosine. Not
        measured.
    network_decay : float, per step
        Of the weights. Not measured.
    network_noise : float, standard deviations
        That is added to the inputs. Not measured.
    clip_least : int, frames
        Of a run without dots, with fewer sure ones of which lips do not go on learning from it. Not
        measured.
    clip_most : int, frames
        That are learned from of such a run, evenly spread. A bound on time.
    looks_frames : int, frames
        That a speaker's appearance is learned from, of all recordings together. Not measured.
    looks_parts : int, recordings
        Of which each is predicted by the others; of fewer, each is cut into parts. Not measured.
    """

    jump: float = 5.0
    far_off: float = 8.0
    fewest_dots: int = 8
    dot_modes: int = 10
    dot_rounds: int = 10
    dot_noise: float = 0.02
    hiding: float = 1.0
    highest_bead: float = 28.0
    facing_dot: float = 0.4
    dots_apart: float = 4.0
    beads_apart: float = 9.0
    corner: float = 2.0
    teeth_beads: tuple[float, ...] = (-15.0, -10.0, -5.0, 0.0, 5.0, 10.0, 15.0)
    ring_beads: int = 20
    ring_away: float = 6.0
    farthest_dots: float = 12.0
    exchanged: float = 0.8
    flattest: float = 0.04
    steepest: float = 30.0
    mouth_sizes: tuple[float, ...] = (0.7, 1.4)
    further_rounds: int = 3
    strained: float = 0.8
    free_modes: int = 60
    starts: int = 48
    left_out: float = 0.2
    blocks: int = 7
    most_noise: float = 0.5
    resting: float = 0.25
    least_resting: int = 10
    worse: float = 0.01
    beyond: float = 2.0
    sudden: float = 2.7
    most_seen: int = 300
    least_frames: int = 200
    spacing: float = 4.0
    coarse: float = 0.4
    finest: float = 1.0
    modes: int = 10
    trained: int = 140
    least_moved: float = 1.0
    frames_a_mode: int = 2
    least_articulated: float = 1.0
    most_built: int = 100
    still: float = 0.5
    near: float = 6.0
    bite_width: float = 5.0
    blink: float = 1.0
    brow: float = 0.25
    opening_pixels: int = 250
    opening_copies: int = 2
    opening_near: float = 4.0
    opening_varied: float = 0.04
    opening_anywhere: float = 0.15
    opening_reach: float = 34.0
    opening_off: tuple[float, ...] = (0.03, 0.05, 0.06, 0.03)
    opening_frames: int = 20
    opening_videos: int = 3
    opening_parted: float = 0.03
    network_hidden: int = 48
    network_epochs: int = 12
    network_batch: int = 256
    network_rate: float = 2e-3
    network_last: float = 0.02
    network_decay: float = 1e-3
    network_noise: float = 0.15
    clip_least: int = 5
    clip_most: int = 60
    looks_frames: int = 100
    looks_parts: int = 5


LEARNING = LearningSettings()
