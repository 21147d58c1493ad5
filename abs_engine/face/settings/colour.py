"""Settings of the colour classes: how they are learned, and how far they are believed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ColourSettings:
    """Settings of the colour classes: how they are learned, and how far they are believed.

    Attributes
    ----------
    worthless : float, separability
        Up to which colours say nothing of lips. Not measured.
    plain : float, separability
        From which on colours say all that they can. Not measured.
    no_lips : float, separability
        Of the better lip, below which it is doubtful that the picture shows lips at all. Measured:
        it has 0.50 to 0.61 in four clips of a face behind a mask or a hand throughout, and 0.77 or
        more in the clips of 16 strangers and eight of GRID.
    least_weight : float, share
        Of their likelihood that colours count in any case: where classes are wrong, they are all
        the surer of it. Chosen from 0.08, 0.1 and 0.2 on altered clips of p04 of the strangers, as
        a compromise. In the two where it matters (blue and blurred) false closures are 8 and 7, 9
        and 11, and 10 and 18, respectively; p01 to p08, unaltered, hardly change.
    deaf : float, slope
        Of apertures by colours with those by landmarks, up to which colours say nothing. With
        `following`, chosen from 0.5 and 0.8, 0.6 and 0.9, 0.7 and 0.9 on p01 to p08 of the
        strangers' clips and films of other heads, p12 in view, with an earlier form of the evidence
        of the lips' distances: apertures differ from gaps read by eye by 1.98, 1.92 and 1.90 mm
        (RMS, mean of clips), from the truth of eight films by 0.78, 0.84 and 0.92 mm, of eight
        others by 0.64, 0.63 and 0.62. In six of the eight clips whose colours open the mouth less
        than 0.8 times as far as landmarks do, both together are no nearer to those gaps than
        landmarks alone; in seven of the eight others they are nearer.
    following : float, slope
        From which on they say all that they can. Chosen with `deaf`.
    most_outdone : float, slope
        At which what colours see beyond landmarks counts most. Measured: about the highest of the
        strangers' clips and GRID's.
    pale_teeth : float, share of the skin's density
        That teeth get within the lips' outline: no skin shows there, and what looks like it is
        rather teeth in shade than lips, or a lip that shines. Chosen of 0, 0.1, 0.3 and 1 on p03,
        p04, p06 and p07 of the strangers' clips, where all are alike, and on GRID's labelled clips
        by the recall of closures: 1.00 with 0.3, 0.99 without.
    outlier : float, share of the lowest peak density
        Below which a colour belongs to no class. Not measured.
    smoothing : float, pixels
        Width of the Hamming window that maps of classes are smoothed by where a whole mouth or face
        is looked at. Not measured.
    skin_components : int
        Gaussians of the skin at most; the Bayesian information criterion chooses. Not measured.
    lip_components : int
        The same of a lip. Not measured.
    mixture_steps : int
        Of expectation and maximisation, for each number of Gaussians that is tried. Not measured.
    independent : float, share of a class's pixels
        That count as samples where the number of Gaussians is chosen: neighbouring pixels are
        alike. Not measured.
    least_component : float, share of a class's pixels
        Below which a Gaussian of it dies out. Not measured.
    least_pixels : int, pixels
        Of a class, weighted by how surely they belong to it, with fewer of which nothing is
        learned. Not measured.
    least_place : float, prior
        Of all classes together, below which a pixel is not learned from. Not measured.
    elsewhere : float, prior
        At least, that a pixel shows none of the classes: its colour may then be any. Not measured.
    least_shown : float, prior
        Of skin or lips that some pixel has at least where these are in the picture. Not measured.
    certain : float, share of the largest prior
        From which on skin is expected surely enough for a first guess. Not measured.
    stray_skin : float, share of such skin
        That is left out of this guess: what is farthest from the rest, nostrils or background. Not
        measured.
    skin_shading : float, a third of log luminance
        Spread that is added to the skin's, for light that changes. Not measured.
    lip_shading : float, a third of log luminance
        The same of lips. Not measured.
    core : float, share of the largest prior
        From which on lips are expected surely enough to learn from. Not measured.
    lips_held : float, share of the pixels where lips are expected
        So many count for anybody's lips. Not measured.
    inside_held : float, share of the pixels where lips are expected
        So many count for what anybody's teeth and dark are like. Not measured.
    unusual : float, share of where lips are expected
        If less looks like anybody's lips, they are taken to be painted. Not measured.
    painted_place : float, share of the largest prior
        From which on the colour of painted lips is looked for. Not measured.
    painted_part : float, quantile
        Of redness there, from which on it is lips. Not measured.
    mix : float, share of the way from skin to lips
        Spread of both by mixing at their border. Not measured.
    mixed_until : float, share of the way from skin to a lip
        Where skin that mixes with the lip is as dense as it. Chosen with `mixed_way` on edges of
        lips that were read by eye in p01 to p08 of the strangers' clips, and on films of ICT heads
        (seed 5), whose edges are sharp: with 0.5 and 0.25, 0.6 and 0.35, 0.7 and 0.45 outer edges
        lie 1.5, 1.1, 0.9 mm above and 1.6, 1.1, 0.7 mm below those that were read (without skin
        of this kind 1.7 and 2.0 mm), and apertures of the films are off by 0.81, 0.81, 0.79 mm.
        Openings get smaller: by 0.7 those of p09 to p16, which were in view, are 2.2 mm (RMS) off,
        by 0.6 2.0.
    mixed_way : float, share of the way from skin to a lip
        Where skin that mixes with the lip lies in the mean. Chosen with `mixed_until`.
    mixed_spread : float, share of the way from skin to a lip
        Standard deviation of that. Not measured.
    least_mixed : float, chromaticity
        Of the way from skin to a lip, below which they are not taken to mix: there is hardly a way
        then. Not measured.
    palest : float, share of the way from skin to teeth
        By which a component of the skin is at most paler than the most frequent one, or it is
        teeth. Measured: 0.4 and less in clips whose skin held no teeth, 1.6 where it did.
    frequent : float, share of the skin
        From which on a pale component is skin under a second light. Measured: teeth that were
        learned for skin were a sixteenth of it.
    less_red : float, share of the way from lips to lit teeth
        That teeth in shade lie on at least. Measured: about half-way where they were looked at.
    skin_chroma : tuple of float, chromaticity
        R, G and B of any skin in neutral light, by which a clip's skin says its light; the chroma
        of teeth lies half-way from skin to light. Not measured.
    dark : tuple of float, features
        The dark of the mouth: its chroma less the skin's, and its luminance, a third of the skin's.
        Not measured.
    teeth : float, a third of log luminance
        Of teeth beside the skin's; those in shade lie half-way between these and the dark. Not
        measured.
    bared_teeth : float, a third of log luminance
        The same of teeth that a smile bares. Measured: of the brighter half of them in ten faces
        that smile it is 0.01 to 0.13.
    inside_spread : tuple of tuple of float, features
        Standard deviations of dark, bared, lit and shaded teeth. Not measured.
    inside_parts : tuple of float, share of the mouth's inside
        Of these. Not measured.
    lips_mean : tuple of float, features
        Lips less skin. Measured: medians inside and around the lips of 33 faces, 8 of the GRID
        corpus and 25 of other pictures, some of them dark, bearded, laughing or in coloured light.
        In none are lips greener than skin; how much redder or darker they are varies.
    lips_spread : tuple of tuple of float, features squared
        How far people and lights differ in that. Measured on the same 33 faces.
    lips_noise : tuple of float, features squared
        Variances of a pixel about its own person's lips. Not measured.
    lip_shade_mean : tuple of float, features
        Lips in their own shade, where they meet and turn in, less lit lips; each throws its red
        back at the other. Measured: of the darkest pixel of each column between closed lips (8
        clips of GRID, 203 frames) the mean is (0.063, -0.045, -0.117); of three heads that were
        drawn without light thrown back (0.018, -0.006, -0.173). Taken a little less red than in
        those videos; of pixels as `chroma.matched` gives them it is (0.044, -0.021, -0.136), but
        with that closures were found no better. Darker yet, and a narrow gap or a tongue in shade
        would be taken for lips.
    lip_shade_spread : tuple of float, features
        Standard deviations of that. Not measured.
    lip_shade_part : float, share of the lips
        That lies in that shade. Not measured.
    beside_teeth_part : float, times the lips' own weight
        Of lips that touch bright teeth and have taken on their chroma. Chosen of 0 and 0.3 on eight
        films of other heads, where apertures are off by 1.28 and 1.19 mm and recall of closed
        frames is 0.93 and 0.98 (on eight others 1.01 and 0.98 mm, 0.92 and 0.92). GRID and the demo
        are alike with both; r of p01 to p08 of the strangers' clips is at most 0.013 lower with
        0.3.
    beside_teeth_way : float, share of the way from lips to bright teeth
        That such a lip's chroma has gone; its standard deviation is half of it. Chosen of 0.3 and
        0.4 along with that part.
    beside_teeth_darker : float, a third of log luminance
        By which they are darker than lit lips, with as much spread. Not measured on its
        own.
    lip_width : tuple of float, features
        Standard deviations of a lip of which nothing is known but a rough colour. Measured: those
        of a pixel about its own person's lips (see `lips_mean`), widened by a fifth.
    lip_held : float, pixels
        That this width counts as. Not measured.
    lip_fitted : float, pixels
        Of such a lip, from which on it may have several Gaussians. Not measured.
    lip_place : tuple of float, features
        By how much a lip's colour may be wrong as its place is. Skin or a dark opening beside it
        differ by three times as much, and may be a third of what is learned. Not measured further.
    parted : float, prior of the inside
        From which on, anywhere in a frame, the mouth is parted there. A closed mouth has 0.35; 0.5
        is an opening of about 2.5 mm as places are blurred last. Chosen of 0.5 and 0.6 on p01 to
        p08 of the strangers' clips, where both are alike.
    parted_weight : float, share
        That a pixel of a parted mouth counts for where lips are learned, if enough frames show it
        shut. Chosen of 0.05, 0.15, 0.2 and 1 on 24 films of other heads, where apertures are off by
        0.81, 0.82, 0.83 and 0.93 mm, and on p01 to p08, where r of p02 falls from 0.98 to 0.96 with
        0.05 (the others are alike).
    least_shut : int, frames
        With the mouth shut, from which on lips are learned from these above all. Not measured.
    rounds : int
        Of expectation and maximisation. Not measured.
    most_pixels : int, pixels
        That colours are learned from at most, evenly spread. A bound on time. Not measured.
    least_spread : float, levels of 255
        Of the chroma of a face, below which a video has no colour. Measured, medians of six frames:
        p01 to p08 of the strangers' clips and GRID's 4.2 to 10; with their colour taken out 0, also
        with noise; tinted sepia 0.6 to 1.0, coded as coarsely as H.264 does at a quality of 32 1.0
        to 1.7, but 2.3 and 3.4 in p03, whose skin is burnt out.
    least_coloured : float, share of the frames
        With colour, from which on those without are left out as colours are learned. Not measured.
    grey_share : float, share of the usual
        Of a face's chroma in a clip's frames with colour, below which a frame has none. Measured,
        every sixth frame of p01 to p16 of the strangers and of a clip of GRID: at least 0.73; with
        the colour taken out and the clip coded, at most 0.1.
    light_face : float, luminance, 0 to 255
        From which on a face's chroma counts as it is; that of a darker one relative to it.
        Measured: a film of a dark brown head (median luminance 58) has a spread of 2.4 before this,
        others of 59 to 90 have 3.2 to 7.0; five such clips tinted sepia, and coded with a quality
        of 32, 1.0 to 1.6.
    most_dim : float, share of that luminance
        That a darker face's luminance is taken to have at least. Chosen on the same clips: with 0.6
        one in sepia would almost pass for colour.
    limit : int, levels of 255
        From which on a channel is at its upper limit. Not measured.
    most_saturated : float, share of a face
        With two channels at their limit, above which it is burnt out. Chosen between 0.02, the
        most of the strangers' clips, GRID's and eight films of other heads, and 0.48, the least
        of three clips (p05, p09, p15) that were brightened until parted lips came out closed;
        p04, brightened alike, has 0.10 and is as it was.
    least_light : float, luminance, 0 to 255
        Of a face, below which a clip without chroma is said to be dark. Measured: 58 and more in
        the darkest film of a dark brown head and all strangers' clips; 23 in p05 with 0.15 of its
        light.
    cells_across : int, cells across a face
        That chroma is averaged in: coarser than the blocks that video keeps one chroma for. Not
        measured.
    luminance_levels : int
        Of luminance, by as many cells each, whose chroma is compared. Not measured.
    inside_components : int
        Gaussians of teeth and of the dark at most, where the place of everything is known. Not
        measured.
    inside : float, prior weight
        Of teeth and dark together where skin and lips have 1: they show on little area. Not
        measured.
    most_labelled : int, pixels
        Of a class that are learned from at most, where places are known. A bound on time. Not
        measured.
    """

    worthless: float = 0.6
    plain: float = 0.9
    no_lips: float = 0.67
    least_weight: float = 0.1
    deaf: float = 0.6
    following: float = 0.9
    most_outdone: float = 2.0
    pale_teeth: float = 0.3
    outlier: float = 2e-4
    smoothing: float = 3.0
    skin_components: int = 3
    lip_components: int = 2
    mixture_steps: int = 25
    independent: float = 0.25
    least_component: float = 1e-3
    least_pixels: int = 30
    least_place: float = 0.02
    elsewhere: float = 0.02
    least_shown: float = 0.2
    certain: float = 0.9
    stray_skin: float = 0.1
    skin_shading: float = 0.03
    lip_shading: float = 0.015
    core: float = 0.6
    lips_held: float = 0.15
    inside_held: float = 0.25
    unusual: float = 0.1
    painted_place: float = 0.5
    painted_part: float = 0.4
    mix: float = 0.2
    mixed_until: float = 0.6
    mixed_way: float = 0.35
    mixed_spread: float = 0.2
    least_mixed: float = 0.01
    palest: float = 0.42
    frequent: float = 0.2
    less_red: float = 0.3
    skin_chroma: tuple[float, ...] = (0.42, 0.33, 0.25)
    dark: tuple[float, ...] = (0.03, -0.03, -0.37)
    teeth: float = -0.10
    bared_teeth: float = 0.06
    inside_spread: tuple[tuple[float, ...], ...] = (
        (0.05, 0.04, 0.11),
        (0.02, 0.02, 0.05),
        (0.02, 0.02, 0.09),
        (0.02, 0.02, 0.07),
    )
    inside_parts: tuple[float, ...] = (0.45, 0.1, 0.27, 0.18)
    lips_mean: tuple[float, ...] = (0.034, -0.044, -0.044)
    lips_spread: tuple[tuple[float, ...], ...] = (
        (8.4e-4, -4.8e-4, -8.7e-4),
        (-4.8e-4, 3.3e-4, 4.0e-4),
        (-8.7e-4, 4.0e-4, 6.0e-3),
    )
    lips_noise: tuple[float, ...] = (1e-4, 1e-4, 1e-3)
    lip_shade_mean: tuple[float, ...] = (0.05, -0.033, -0.11)
    lip_shade_spread: tuple[float, ...] = (0.03, 0.02, 0.035)
    lip_shade_part: float = 0.1
    beside_teeth_part: float = 0.3
    beside_teeth_way: float = 0.3
    beside_teeth_darker: float = 0.06
    lip_width: tuple[float, ...] = (0.012, 0.008, 0.05)
    lip_held: float = 40.0
    lip_fitted: float = 80.0
    lip_place: tuple[float, ...] = (0.012, 0.010, 0.04)
    parted: float = 0.5
    parted_weight: float = 0.2
    least_shut: int = 2
    rounds: int = 10
    most_pixels: int = 12_000
    least_spread: float = 2.7
    least_coloured: float = 0.25
    grey_share: float = 0.4
    light_face: float = 100.0
    most_dim: float = 0.65
    limit: int = 250
    most_saturated: float = 0.25
    least_light: float = 40.0
    cells_across: int = 24
    luminance_levels: int = 12
    inside_components: int = 2
    inside: float = 0.3
    most_labelled: int = 6000


COLOURS = ColourSettings()
