"""Settings of landmarks as evidence: their noise, and what they count."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class LandmarkSettings:
    """Settings of landmarks as evidence: their noise, and what they count.

    Attributes
    ----------
    inner_together : float, landmarks
        Of the inner lips that count as one, as they err together. Measured: of what the network is
        off by within a person, the 936 numbers of all landmarks move like 9 independent ones; of
        the lips, most of what they have in common moves with the head's pose.
    outer_together : float, landmarks
        The same of the outer lips, whose line is less sharp; where a person's lips thicken as no
        mode does, it holds the inner ones apart. Chosen of 2 and 8 on p02 and the closed lips of
        p15 of the strangers' clips, where 8 is better, and on GRID's closures, where both are as
        good.
    others_together : float, landmarks
        The same of all others. Not measured.
    openings_together : float, distances
        Of the nine between the inner lips that count as one. Chosen of 4, 8 and 16 on p01 to p08 of
        the strangers' clips and 16 films of other heads: with 4, p04 agrees better with gaps read
        by eye (r of 0.90 for 0.88), and more parted lips of the films are found closed (precision
        0.96 for 0.97); with 16, p04 agrees less (0.86). All else is alike.
    opening_least : float, mm
        Standard deviation of such a distance where lips touch. Measured beside gaps read by eye in
        p01 to p08: 1.1 mm (RMS; in most frames 0.1); where they are 3 to 8 mm apart 1.2 mm, at 8 to
        15 mm 1.8, beyond 2.9 (robust). Of 0.7 and 1.0, the second is better on films of other
        heads by up to 0.03 mm of their apertures, and neither on p01 to p08.
    opening_share : float, share of the distance
        That is added to it, in squares. Measured: the same. With twice as much, apertures of p01 to
        p08 agree as well with those gaps, less with the detector's.
    opening_pixels : float, px
        That are added to it, in squares. Not measured.
    most_misfit : float, as `FrameLandmarks.misfit`
        From which on landmarks are no face's. Measured: of faces about 1 to 4, in a shout 7; of
        points strewn over a picture 25.
    stray : float, standard deviations
        From where on a landmark, or a distance between lips, counts less and less. Not measured.
    stray_lips : float, standard deviations
        The same of the lips, 4 mm: the ends of how they move are where a fit errs most, and where
        landmarks are needed. Chosen with p12, p14 and p15 of the strangers' clips in view.
    hidden : float, cosine
        Between surface and line of sight, below which a landmark is hidden: a frame's is guessed,
        a head's is not found. Not measured.
    guessed : float, weight
        Of such a landmark. Not measured.
    steps : int
        Gauss-Newton steps of a frame's landmarks at most. Not measured.
    factors_between : int
        Factors of a person's errors that are learned. Not measured.
    factors_within : int
        Factors of a frame's errors that are learned. Not measured.
    least_noise : float, mm
        Of what no factor explains, of a frame and of a person: the drawn people are too few to know
        in which directions the network hardly errs, and a fit would trust these most. Not measured.
    posture_share : float, share of how far the mouth's modes move a landmark
        That its place in a person's frames is off by. Chosen on eight films of other heads, by the
        head's rotation: off by 3.7 degrees with 0, 3.2 with 1, 3.0 with 2, 2.9 with 4; the least
        that gives nearly all of it. On eight others the error in the person's own frame falls from
        1.8 to 1.6.
    bias_share : float, share
        Of what several frames of a person are off by, that is the person's own bias. Not measured.
    within : float, share of the deviation
        That is left between postures of a person. Measured on the drawings that the deviations were
        measured on: 0.5 to 0.8 of 1.7 to 2.0 mm; the rest moves with the view, as a pose does.
    closest : int, frames
        The least open ones, that say by how much the network sees inner lips apart that meet: there
        other evidence is surest, and an error of it, teeth taken for lips, the smallest. Not
        measured.
    most_parted : float, mm
        By which the network may see inner lips apart that meet, as far as that is taken for its
        bias. Measured: 0.9 and less in p01 to p11 and p13 to p16 of the strangers and in GRID's
        clips, up to 1.3 in p12; 1.5 to 4.7 where parts of these clips without closed lips are
        tracked, whose openings then came out 1.4 to 3.4 mm too small.
    stray_sighting : float, mm
        A sighting that is farther off counts as this far. Not measured.
    least_sightings : int
        Of a landmark, of a head that it is found on. Not measured.
    tried : int, points
        Of the surface about a triangulated landmark, of which the best is its own. Not measured.
    drawn_pitches : tuple of float, rad
        Of the drawings of a head in which its landmarks are found. Not measured.
    drawn_yaws : tuple of float, rad
        The same, each with each. Not measured.
    drawn_side : int, px
        Of such a drawing. Not measured.
    drawn_depth : float, mm
        From the camera to the head in it. Not measured.
    drawn_ambient : float, share of the texture's brightness
        By the light of the room in it. Not measured.
    drawn_diffuse : float, share of the texture's brightness
        By its lamp, where skin faces it. Not measured.
    drawn_wall : float, levels of 255
        Of the wall behind the head. Not measured.
    drawn_lamp : tuple of float, camera frame
        Direction to the lamp. Not measured.
    least_deviation : float, mm
        Of a landmark: one that hardly any side shows may agree by chance. Not measured.
    place_rounds : tuple of float, mm
        How unsure a class's place is in each round: the landmarks' noise, then that of fits. Not
        measured.
    least_motion : float, mm
        Standard deviation of apertures from which on colours are judged by how they grow with them;
        from open lips alone otherwise. Not measured.
    plainly_open : float, mm
        Aperture by landmarks from which on colours are asked whether they see it, too. Chosen with
        altered clips of p04, p10 and p12 of the strangers in view (blurred, small, tinted).
    fewest_open : int, frames
        So open at least, for their median to count. Chosen with a filmed stranger in view, of
        whom landmarks see one closed mouth open.
    person_limit : int, evaluations
        Of the person's fit at most. Not measured.
    shift_deviation : tuple of float, rad, mm and share of the depth
        How far the landmarks put a whole clip's poses off. Not measured.
    usual_deviation : tuple of float, mm
        Of landmarks on a single head, whose own points are chosen to fit and which seems surer.
        Measured: medians over the six bundled people in five postures.
    """

    inner_together: float = 2.0
    outer_together: float = 8.0
    others_together: float = 100.0
    openings_together: float = 8.0
    opening_least: float = 1.0
    opening_share: float = 0.15
    opening_pixels: float = 0.5
    most_misfit: float = 10.0
    stray: float = 3.0
    stray_lips: float = 8.0
    hidden: float = 0.15
    guessed: float = 0.05
    steps: int = 12
    factors_between: int = 25
    factors_within: int = 40
    least_noise: float = 1.5
    posture_share: float = 2.0
    bias_share: float = 0.95
    within: float = 0.5
    closest: int = 3
    most_parted: float = 1.0
    stray_sighting: float = 6.0
    least_sightings: int = 3
    tried: int = 96
    drawn_pitches: tuple[float, ...] = (-0.15, 0.1)
    drawn_yaws: tuple[float, ...] = (-0.6, -0.3, 0.0, 0.3, 0.6)
    drawn_side: int = 400
    drawn_depth: float = 700.0
    drawn_ambient: float = 0.45
    drawn_diffuse: float = 0.65
    drawn_wall: float = 110.0
    drawn_lamp: tuple[float, ...] = (0.3, -0.5, -1.0)
    least_deviation: float = 1.0
    place_rounds: tuple[float, ...] = (3.0, 2.0)
    least_motion: float = 0.7
    plainly_open: float = 3.0
    fewest_open: int = 3
    person_limit: int = 80
    shift_deviation: tuple[float, ...] = (0.002, 0.002, 0.002, 0.8, 1.0, 0.003)
    usual_deviation: tuple[float, ...] = (1.7, 1.6, 4.4)


LANDMARK_EVIDENCE = LandmarkSettings()
