"""Settings of the fit of a frame, by face."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class HeadFitSettings:
    """Settings of the fit of a frame by a head's colours.

    Attributes
    ----------
    drawn_mouth : float, drawn pixels across the mouth
        At which a frame is compared. Detail against time. Not measured.
    window : tuple of float, mouth widths
        Width and height of what is looked at around a mouth, a shell's too. Not measured.
    lower : float, mouth widths
        By which the middle of that lies below the middle of the lips: jaws open downwards. Not
        measured.
    sides_across : float, independent observations
        Across a mouth at most, each at least as large as a shell's `side`. Not measured.
    smoothing : float, mouth widths
        Width of the Hamming window that log-likelihoods are smoothed by. Not measured.
    pull : float, mouth widths
        The same of the maps that pull on facets: how far a boundary is felt. Not measured.
    in_shade : float, share
        Of the probability of teeth and dark that lips get: they throw shade. Not measured.
    red_inside : float, share
        Of the probability of lips that the dark inside gets: tongue, gums and shaded teeth are as
        red. Chosen of 0 and 0.15 on p01 to p08 of the strangers' clips.
    in_line : float, share
        The same as `in_shade` of dark, and of teeth in shade, in a thin line, which closed lips
        show where they meet. Not measured. With dark alone, one of 14 closures in ten sentences of
        a speaker of GRID was missed; with both, none.
    line : float, mouth widths
        Height of such a line. Not measured.
    line_pixels : float, image pixels
        Or so much, if that is more: no picture shows a line sharper than that. Not measured.
    least_thickness : float, share of a lip's height at rest
        That it keeps in any posture: lips that are pressed or rolled in show about as much. Not
        measured.
    opening_weight : float, independent observations
        That each pixel of an opening counts as: neighbouring pixels have much of what the network
        sees in common. Chosen from 0.5, 0.25, 0.15 and 0.08 on the first five speakers of labelled
        close-ups: parted or closed right in 86, 89, 91 and 94 % of the frames, inner lips off by
        1.6, 1.8, 2.0 and 2.2 % of the mouth's width.
    border_reach : int, drawn pixels
        To either side of a border, by which its curvature is measured. Not measured.
    first_stride : float, mm
        That the node which moves most is first pushed by. Not measured.
    shared_reach : float, standard deviations
        To which what all frames share may go. Not measured.
    shared_step : float, standard deviations
        First step of that. Not measured.
    resolution : float, mm
        Gaps of lips that differ by less are not distinguished in a picture, where its evidence has
        no curvature that says so. Not measured.
    open_from : float, mm
        Lips that are farther apart are open. Measured: it hardly matters; with 5 mm the picture is
        against it in all but 2 of 61 frames of six real clips whose lips are 1 to 5 mm apart.
    usually_closed : float, share of the frames
        In which anybody's lips touch in speech; in GRID's labelled clips in 0.38. Measured with
        0.25, 0.4 and 0.5: precision of closed frames 0.99, 0.98 and 0.98 in these clips (recall
        1.00), 0.95, 0.92 and 0.92 in films of unknown heads (seed 5; recall 0.98, 0.99 and 0.99);
        recall of six known people's 0.85, 0.89 and 0.94 (precision 1.00). Strangers' apertures
        agree with the detector's alike with 0.25 and 0.4, and a little less with 0.5.
    usual_gap : float, mm
        By which lips part at most; assumed.
    """

    drawn_mouth: float = 72.0
    window: tuple[float, float] = (1.6, 1.25)
    lower: float = 0.08
    sides_across: float = 20.0
    smoothing: float = 0.03
    pull: float = 0.06
    in_shade: float = 0.15
    red_inside: float = 0.15
    in_line: float = 0.7
    line: float = 0.03
    line_pixels: float = 2.5
    least_thickness: float = 0.35
    opening_weight: float = 0.15
    border_reach: int = 2
    first_stride: float = 2.0
    shared_reach: float = 4.0
    shared_step: float = 0.3
    resolution: float = 0.5
    open_from: float = 3.0
    usually_closed: float = 0.4
    usual_gap: float = 15.0


HEAD_FIT = HeadFitSettings()


@dataclass(frozen=True, slots=True)
class ShellFitSettings:
    """Settings of the fit of a frame by a shell's colours.

    Attributes
    ----------
    drawn_mouth : float, drawn pixels across the mouth
        At which a frame is compared. Detail against time. Not measured.
    side : float, px
        Side of an independent observation, as pixels share their chroma two by two. Not
        measured.
    side_of_mouth : float, mouth widths
        Or so much, if that is more: over so much the errors of a shell last. Not measured.
    width : float, standard deviations
        Of the prior about each shape that was seen. Not measured.
    in_shade : float, share
        Of the probability of dark that lips get: they throw shade on each other. Not measured.
    mode_limit : float, standard deviations
        Of a mode that a fit may go to. Not measured.
    pose_free : tuple of float, rad and mm
        Standard deviations of a pose that is estimated along. Not measured.
    tried : int
        Best of the starts that are all descended from. Not measured.
    relaxed_limit : int, evaluations
        Of a shape that several views share at most. Not measured.
    placed : int, times
        That a shell is drawn to place it by its blob: what is visible changes a little with the
        place. Not measured.
    """

    drawn_mouth: float = 92.0
    side: float = 2.0
    side_of_mouth: float = 0.04
    width: float = 0.7
    in_shade: float = 0.25
    mode_limit: float = 6.0
    pose_free: tuple[float, ...] = (0.05, 0.05, 0.05, 2.0, 2.0, 12.0)
    tried: int = 4
    relaxed_limit: int = 60
    placed: int = 3


SHELL_FIT = ShellFitSettings()


@dataclass(frozen=True, slots=True)
class TalkingFitSettings:
    """Settings of the fit of a frame by a talking face.

    Attributes
    ----------
    penalty_share : float, costs of a wrong match
        That A(a) is worth at strength 1. Not measured.
    tolerance : float, costs of a wrong match
        By less than which a simplex's values differ when it stops. Not measured.
    tolerance_of_points : float, costs of a wrong match
        The same beside local appearance, for which a wrong match costs far more than noise does.
        Chosen on another person's visemes: with 1e-4 points end a twentieth farther off, with 1e-6
        as far.
    limit : int, evaluations
        Of a frame at most. Not measured.
    placed_limit : int, evaluations
        Of a pose alone, with the posture held, at most. Not measured.
    from_neutral : float, times the first simplex
        Where a fit starts far away. Not measured.
    whitened : float, share of A(a)'s strength
        That counts beside whitened differences, whose noise is less of what a wrong match costs
        than that of raw ones. Chosen on visemes that nothing is reported of.
    margin : float, px at 1 pixel per mm
        Around the face as it is at the start. Not measured.
    least_window : int, px
        Of what a picture shows of a face, in width and height, to be compared. Not measured.
    """

    penalty_share: float = 0.1
    tolerance: float = 1e-4
    tolerance_of_points: float = 1e-5
    limit: int = 600
    placed_limit: int = 300
    from_neutral: float = 3.0
    whitened: float = 0.1
    margin: float = 10.0
    least_window: int = 8


TALKING_FIT = TalkingFitSettings()


@dataclass(frozen=True, slots=True)
class BeliefSettings:
    """Settings of standard deviations: the uncertainty that no curvature of a fit knows of.

    The numbers of a measure are a factor on the deviation by curvature, the least deviation, a
    share of the measure's size and the most that this share adds; see `belief.Unknown`.

    Attributes
    ----------
    aperture : tuple of float, 1, mm, share and mm
        Chosen on eight films of unknown ICT heads (seed 1) and three of bundled people as unknown
        (walter, clara, kofi), pupil distance and camera given: errors grow with the opening up to 3
        mm and hardly beyond. Measured on seeds 2 and 3 and three other people: 90 % intervals hold
        93 %, of openings found between 1 and 6 mm 94 % (77 % with a share without a limit).
    width : tuple of float, 1, mm and share
        Chosen on the films of seed 1, where 90 % intervals hold 90 % (75 with a share of 0.0166,
        which was enough for colours alone); on others (seeds 5, 63 and 64) 90, 99 and 75 %. The
        mean difference of widths is left out: ICT's corners are other points.
    agreed : float, share of the aperture's deviation
        What is left where the landmarks agree; how far they are off, in joint deviations, is added
        in quadrature. Chosen from 0.7 to 0.9 with `aperture`, on the same films; with less,
        `closed_probability` is too sure.
    by_landmarks : tuple of float, 1, mm, share and mm
        What is added to the aperture's, in quadrature, where an aperture rests on landmarks alone;
        its square counts by the weight that colours lack (`ColourClasses.weight`). Chosen on p01 to
        p08 of the strangers beside gaps read by eye, of which 90 % intervals hold 91 % with it, 86
        with a second number of 0.75, and 76 without. Measured on p09 to p16: 88, 86 and 76 %. In
        films colours lack next to nothing.
    grey_aperture, grey_width : tuple of float, 1, mm, share and mm
        The same of a video without colour; the last is the most that the size adds. Chosen on p01
        to p08 of the strangers with their colour taken out in two ways, beside gaps read by eye and
        widths found with it, and on eight films of other heads in grey.
    coarse : float, pixels^2 / mm
        Deviation of aperture and width, in mm, for the square of a pixel's size at the mouth, mm;
        added in quadrature. Lip points needed none. Chosen on p01 to p08 of the strangers and four
        clips of GRID, made smaller by 2, 3 and 4, against themselves in full size: where a pixel is
        larger than 5 mm, 90 % intervals of the aperture hold 92 to 96 % instead of 51 to 71.
        Measured on p09 to p16 and the other four: 84 % instead of 64, and 86 instead of 74 from 3.5
        mm on.
    unexplained : tuple of float, share and mm
        By how much less of a frame is explained than of its clip's median one, from where on the
        aperture's deviation grows, and by how much it would for all of the picture; added in
        quadrature. Chosen on p01 to p08 of the strangers, as they are, and with a word written over
        the lower lip in some frames: there 90 % intervals hold 50 % of the apertures (17 without)
        and would hold two thirds with twice as much; where nothing is written, 93 % (91). Measured
        on p09 to p16: 68 % (13), and 88 (88).
    protrusion : tuple of float, 1, mm and share
        The same. Chosen on the three people.
    points : tuple of tuple of float, 1, mm and share
        The same of lip points along the head's axes. Chosen on the three people; of each clip the
        mean offset of all points is left out: where an unknown head's origin lies, nothing shows.
    rotation : tuple of float, rad
        Least deviations about the camera's axes, mostly what a person's frames all have in common.
        Chosen on the films of `aperture`.
    translation : tuple of float, mm
        The same of the position, chosen on the same films.
    """

    aperture: tuple[float, ...] = (0.35, 0.25, 0.4, 1.25)
    width: tuple[float, ...] = (0.94, 0.0, 0.024)
    agreed: float = 0.8
    by_landmarks: tuple[float, ...] = (0.0, 1.0, 0.3, 4.0)
    grey_aperture: tuple[float, ...] = (0.4, 1.5, 0.6, 4.0)
    grey_width: tuple[float, ...] = (1.19, 1.5, 0.021)
    coarse: float = 0.07
    unexplained: tuple[float, float] = (0.04, 100.0)
    protrusion: tuple[float, ...] = (0.0, 0.72)
    points: tuple[tuple[float, ...], ...] = ((1.25, 0.11), (1.27, 0.43), (0.0, 1.38))
    rotation: tuple[float, ...] = (0.06, 0.018, 0.012)
    translation: tuple[float, ...] = (1.2, 4.4, 8.0)


BELIEF = BeliefSettings()
