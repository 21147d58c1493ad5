"""Settings of the shapes of heads and mouths: how people differ, and how mouths move."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ShapeSettings:
    """Settings of the shapes of heads and mouths: how people differ, and how mouths move.

    Attributes
    ----------
    expression_modes : int
        Modes of the mouth. Chosen of 10 and 20 on p01 to p08 of the strangers' clips and on GRID,
        along with one-sided and sideways postures: r of the width with the detector's rises from
        0.84 to 0.97 in p07, precision and recall of closures stay 0.98 and 1.00.
    mode_limit : float, standard deviations
        Of a mode of the mouth, at most, in a fit: wide enough that the prior decides. Chosen of 3.5
        and 8 on eight films of other heads (seed 1). With 3.5, a quarter to a third of the frames
        of two films ended at the limit; with 8, none do, and the aperture is off by 1.03 mm instead
        of 1.19.
    reach : float, mm
        From the mouth: what is farther off, but for its inside, is never in sight. Not measured.
    one_sided : float, share of the postures
        In which one side of a pair takes less part than the other, as in a smirk. Chosen with
        `expression_modes`.
    uneven : float, share
        By which both sides of a pair differ from its weight at most. Not measured.
    recorded : float, share of the postures
        That are a real person's; see `face.shape.mouth`. Chosen of 0, 0.2 and 0.5 on p01 to p08 of
        the strangers' clips, where r of the width with the detector's is 0.57, 0.96 and 0.99 in p07
        and 0.85, 0.89 and 0.89 in p02, and on the demo, where the head's direction is off by 0.5,
        0.6 and 0.8 degrees and with 0.5 a closed frame is missed.
    authored : int, postures
        That are drawn of those that nobody recorded. Not measured.
    jaw_form : tuple of float, exponents
        Of the beta distribution of the jaw's opening in them. Not measured.
    lips_closed : float, share of them
        In which lips close, as in p, b and m. Not measured.
    least_closed : float, share of the jaw's opening
        By which they then close at least. Not measured.
    half_closed : float, share of the jaw's opening
        By which they close in the others at most. Not measured.
    action_weights : tuple of float, weight
        Largest of each action of the mouth in them, see `face.shape.mouth.ACTIONS`. Not measured.
    action_shares : tuple of float, share of them
        In which each of these takes part. Not measured.
    scanned_units : float, share
        Of an unknown person's postures that are made across the face with face units after scans
        (ICT FaceKit), not with the bundled head's; from front to back all are made with those of
        scans, see `face.shape.mouth.mouth_shape`. Assumed, as neither is known to be more like
        people. Measured with 0, 0.5 and 1, for all directions alike, on 16 films of that very model
        (seeds 1 and 2), where 1 is bound to do best: lips are off by 1.6, 1.5 and 1.4 mm, and
        precision of closed frames is 0.98, 0.97 and 0.94. With 0.5 and the depth of scans 1.4 mm
        and 0.97.
    sideways : float, ratio
        How far an unknown person's mouth goes to a side, as a share of how far it does in the
        postures; the recorded ones were made to show its range. Chosen of 0.5 and 1 on 16 films of
        ICT's heads (seeds 1 and 5): lips' motion across the face is off by 0.81 mm instead of 0.85,
        as less of what a turned head moves is taken for lips that go to a side. Measured on the
        eleven strangers' clips whose yaw varies by more than 2 degrees: lips go to a side with it
        by 2.9 mm a radian instead of 4.0.
    widest_jaw : float, weight of `jawOpen`
        Beyond which it is yawning, not speech. Not measured.
    lip_weight : float, times the skin
        That lips count where modes of the mouth are found. Not measured.
    mouth_reach : float, mm
        From the lips, over which a difference of people fades. Not measured.
    mouth_far : float, times that
        Beyond which nothing differs. Not measured.
    target_pair : float, weight
        Standard deviation of MakeHuman's targets in pairs. Chosen so that the distance of the eyes
        spreads by 6 % and the mouth's width by 9 %, as in people.
    target_alone : float, weight
        The same of targets alone, chosen by the same.
    target_macro : float, weight
        The same of whole people, chosen by the same.
    mouth_target : float, weight
        Standard deviation of MakeHuman's targets of a whole mouth in a person's. Not measured.
    lip_target : float, weight
        The same of those of a single lip. Not measured.
    scanned : float, share
        Of an unknown person's prior that comes from a face model made after scans (ICT-FaceKit);
        the rest is the bundled head's, which an artist made. The mean lies as far from the one to
        the other; where lips end is wholly the model's. Chosen of 0, 0.3 and 0.5 on eight films of
        ICT's heads (seed 1), whose rotation is off by 1.6, 1.4 and 1.4 degrees, and on six films
        of the bundled people as unknown, whose lips are off by 2.7, 2.8 and 2.9 mm.
    identity_modes : int
        Directions of targets, smooth fields and people's components together that are kept.
        Measured: they hold 98 % of the variance that proportions leave of the first two, 99 % of
        all.
    head_breadth : float, mm
        Standard deviation of people. From Gordon et al. 1989 (ANSUR), men's, differences of size
        among them.
    head_length : float, mm
        The same, from the same source.
    head_height : float, mm
        The same above the nose's root, about as much. Not measured.
    crown_sideways : float, mm
        The same of how far the crown lies to a side. Not measured.
    ears : float, mm
        The same of how far an ear stands out. Not measured.
    between_eyes : float, share of the way from eye to eye
        About the middle of the eyes, where the nose's root is looked for. Not measured.
    above_ears : float, share of the way from the nose's root to the crown
        Above which a head is skull. Not measured.
    smooth_scales : tuple of tuple of float, mm
        Standard deviation and reach of what a head's targets leave of other people's heads: of its
        whole proportions, and of single features. Not measured.
    smooth_samples : int, points
        That smooth fields are found on. A bound on time.
    smooth_fields : int
        Of a coordinate, the widest, that are kept. Not measured.
    asymmetry : float, ratio
        Standard deviation of what smooth fields let the two sides of a face differ by, over that of
        what they share. Chosen on eight films of other heads: with 0.1, 0.25, 0.5 and 1 the fitted
        head lies 1.7, 1.9, 2.3 and 2.6 degrees off the true one, before outlines were looked at.
    usual_weight : float, weight
        Standard deviation of a face unit, where nothing is known of the speaker. Not measured.
    border_spring : float, N/mm
        At each node of a shell's outermost ring: soft, as the jaw takes the chin along. Not
        measured.
    young : float, N/mm^2
        Young's modulus of lips and skin in learned physics. Not measured.
    thickness : float, mm
        Of them. Not measured.
    poisson : float, ratio
        Poisson's, of them: skin that is pulled one way hardly narrows the other way, as it bulges.
        Not measured.
    shear : float, share of the shear modulus
        That resists slopes out of the plane; more than a plate's 5/6, which would let the lips'
        edges flap. Not measured.
    lip_share : float, times a node of the skin
        That a node of the lips counts where learned physics moves a head. Not measured.
    weight_cost : float, mm
        Of the lips' motion that a unit of weight costs, beside 1 mm of misfit. Not measured.
    pinched : float, share of the gaps at its sides
        That a mouth's middle is open by at least. Measured: of 1,879 frames of a recorded face
        whose mouth is open by more than 1 mm, on the bundled head, it is so by 0.97 or more in 99.9
        %; of postures drawn from the modes' own Gaussian by less than 0.7 in 5 %.
    pinch_slack : float, mm
        That this may be missed by, for lips whose middle hangs lower than the bundled head's. Not
        measured.
    lip_reach : float, share of half the mouth's width
        To both sides of its middle, over which heights of lips are held. Not measured.
    prototype_limit : float, standard deviations
        Of a mode in a posture that a fit begins with, at most. Not measured.
    still_below : float, mm
        Below the tip of the nose, where skin begins that hardly moves in speech. Not measured.
    still_above : float, mm
        Above the eyes, where it ends. Not measured.
    still_behind : float, mm
        Behind the hindmost corner of the eyes, up to which it lies. Not measured.
    penalty_softness : float, standard deviations
        From the corpus' mean, beyond which the penalty of improbable parameters grows much faster
        than a Gaussian's. Not measured.
    penalty_strength : float, the error's units
        Of that penalty, unless another is given. Not measured.
    penalty_shrunk : float, share of the way to the identity
        That the corpus' covariance is drawn for it, so that few or dependent postures make no
        direction impossible. Not measured.
    left_motion : float, share of a mode's variance
        That is left to it at least where it is mostly error of observation. Not measured.
    point_noise : float, mm
        By which a coordinate is off at least, however well a model fits. Not measured.
    uncertain_parameter : float, standard deviations
        By which an articulatory parameter may be expected to be off where points are missing; with
        more, they do not determine it. Chosen on the bundled people: six points on lips, jaw and
        teeth are expected to be off by 0.9 to 1.1 in the worst parameter (clara's are by 1.4), four
        on the lips by 4.2 to 5.7 (clara's by 4.6), eight by 0.4 to 0.5.
    """

    expression_modes: int = 20
    mode_limit: float = 8.0
    reach: float = 85.0
    one_sided: float = 0.4
    uneven: float = 0.15
    recorded: float = 0.2
    authored: int = 4000
    jaw_form: tuple[float, float] = (1.0, 1.8)
    lips_closed: float = 0.35
    least_closed: float = 0.7
    half_closed: float = 0.25
    action_weights: tuple[float, ...] = (
        0.7, 0.9, 0.5, 0.6, 0.4, 0.5, 0.4, 0.7, 0.8,
        0.6, 0.7, 0.3, 0.3, 0.5, 0.5, 0.4, 0.4, 0.3,
    )  # fmt: skip
    action_shares: tuple[float, ...] = (
        0.3, 0.35, 0.3, 0.3, 0.2, 0.15, 0.15, 0.35, 0.35,
        0.15, 0.2, 0.15, 0.15, 0.15, 0.15, 0.12, 0.12, 0.15,
    )  # fmt: skip
    scanned_units: float = 0.5
    sideways: float = 0.5
    widest_jaw: float = 0.55
    lip_weight: float = 5.0
    mouth_reach: float = 30.0
    mouth_far: float = 2.5
    target_pair: float = 0.3
    target_alone: float = 0.2
    target_macro: float = 0.13
    mouth_target: float = 0.5
    lip_target: float = 0.6
    scanned: float = 0.3
    identity_modes: int = 96
    head_breadth: float = 5.4
    head_length: float = 7.1
    head_height: float = 7.5
    crown_sideways: float = 3.0
    ears: float = 3.0
    between_eyes: float = 0.035
    above_ears: float = 0.2
    smooth_scales: tuple[tuple[float, float], ...] = ((3.0, 60.0), (1.5, 25.0))
    smooth_samples: int = 400
    smooth_fields: int = 60
    asymmetry: float = 0.1
    usual_weight: float = 0.3
    border_spring: float = 0.01
    young: float = 0.1
    thickness: float = 2.0
    poisson: float = 0.0
    shear: float = 1.5
    lip_share: float = 3.0
    weight_cost: float = 0.02
    pinched: float = 0.9
    pinch_slack: float = 0.7
    lip_reach: float = 0.6
    prototype_limit: float = 3.0
    still_below: float = 8.0
    still_above: float = 45.0
    still_behind: float = 25.0
    penalty_softness: float = 3.0
    penalty_strength: float = 0.01
    penalty_shrunk: float = 0.1
    left_motion: float = 0.05
    point_noise: float = 0.02
    uncertain_parameter: float = 1.5


SHAPE = ShapeSettings()
