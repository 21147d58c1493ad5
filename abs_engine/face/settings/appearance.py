"""Settings of textures and of the local appearance of points."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class AppearanceSettings:
    """Settings of textures and of the local appearance of points.

    Attributes
    ----------
    facing : float, cosine
        Between normal and line of sight; what is seen flatter is turned away. Not measured.
    nearer : float, mm
        Of depth, by which something must be nearer to hide a point, besides the surface's own
        slope. Not measured.
    often : float, share of the training frames
        That must show a point for it to be chosen. Not measured.
    squarely : float, cosine
        Least mean between a point's normal and the line of sight: flatter, near the outline, its
        filters see the background too, and a small turn of the head changes them more than speech
        does. Not measured.
    sigma : float, drawn pixels
        Scale of the filters, unless another is given: the paper's.
    ridge : float, frames
        Weight of the wish that a texel or a point does not depend on the parameters; see
        `LinearFits.solve`. Not measured.
    ridges : tuple of float, frames
        That are tried for `ridge` where there are several recordings; with the last a fit is nearly
        constant. Not measured.
    alone : float, share of each component's noise
        That is taken for its own: in a few dozen frames, that of hundreds of components cannot be
        distinguished from noise that they have in common. Not measured.
    alone_tried : tuple of float, share of each component's noise
        That are tried for `alone` where there are three recordings or more, or frames of which no
        recording is known. Not measured.
    highest : float, leverage
        Of a frame at most: one that alone decides about an item has nearly 1. Not
        measured.
    common : int
        Directions of common noise that are kept. Not measured.
    least_own : float, share of the variance
        That counts as not common, where few frames hold no more. Not measured.
    least_spread : float, median spreads
        That a component's noise, or a texel's, counts as at least. Not measured.
    frames_each : int, frames
        For each number fitted at least, where what is left says how uncertain a texel is. Not
        measured.
    texture_sizes : tuple of int, texels
        Side of a texture, least and largest. The latter is a bound on time. Not measured.
    window_step : float, ratio
        Of neighbouring scales of the maps between which a deformed window is interpolated. Not
        measured.
    window_reach : float, ratio
        To which a deformed window grows or shrinks at most. Not measured.
    beside : float, mouth widths
        Above and below a corner that are beside it; farther off all is above or below. Chosen on
        five speakers of the TaL corpus, the first by name.
    doubt : float, share of a pixel
        That may be anything, whatever the network of openings says. Not measured.
    """

    facing: float = 0.15
    nearer: float = 1.0
    often: float = 0.6
    squarely: float = 0.5
    sigma: float = 2.0
    ridge: float = 1.0
    ridges: tuple[float, ...] = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0)
    alone: float = 0.05
    alone_tried: tuple[float, ...] = (0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.9, 1.0)
    highest: float = 0.95
    common: int = 6
    least_own: float = 0.1
    least_spread: float = 0.1
    frames_each: int = 2
    texture_sizes: tuple[int, int] = (64, 1024)
    window_step: float = 1.25
    window_reach: float = 2.0
    beside: float = 0.1
    doubt: float = 0.03


APPEARANCE = AppearanceSettings()


@dataclass(frozen=True, slots=True)
class ShadingSettings:
    """Settings of shaded skin.

    Attributes
    ----------
    least_motion : float, mm
        By which postures move skin that is compared, in the root of the modes' squares. Not
        measured.
    together : int, points
        Compared for each observation, about: all vertices of the skin of a bundled head that is
        known, fewer of a finer mesh's, and every fourth of a fitted head's, in the mesh's order. As
        vertices do, they lie closer together near the lips. Measured on films of unknown ICT
        heads (seeds 61 and 62) with all of about 1000, and with 260: the lips' motion is off by
        0.96 and 0.80, and by 0.99 and 0.83 mm. Points spread evenly instead (300): 1.02 and 0.84
        mm, and a lower r of the width. Six known people's lips are off by 0.81 mm with all, and by
        0.88 with 260.
    facing : float, cosine
        Least between a point's normal and the line of sight. Not measured.
    margin : int, pixels
        Of picture that is kept about the points, so far do they move in a fit. Not measured.
    smoothing : float, pixels
        Of the picture, against its noise. Measured: 1.2 does as well.
    rounds : int
        Of colours and light in turn. Not measured.
    wrong : float, median errors
        From which a point counts less in the light. Not measured.
    least_light : float, share
        That holds numbers of the light near 0 where no point shows them. Not measured.
    alike : float, frames
        As many as a point's colour is taken to be that of most. Measured on seed 1 of unknown ICT
        heads: with ten times as many, motion is as good and apertures less so.
    least_noise : float, share of the brightness
        In each channel, however well the frames are explained. Not measured.
    fewest : int, points of each harmonic
        In all frames, with fewer of which light is not learned. Not measured.
    tail : float, standard deviations
        From which an error counts ever less. Not measured.
    brightness : tuple of float, ratio
        Least and greatest, to the clip's, that a frame may have in a channel. Not measured.
    own_light : int, harmonics
        That a frame's light may differ by. Measured, 0, 4 and 9: unknown ICT heads are as good
        with any of them, and of four strangers' clips one is better with 4 and 9.
    spot : float, mm^2
        Of skin that is one observation. Measured: errors are alike over 80 to 340 in films and real
        clips. Six bundled people's lips are off by 0.81 mm, the motion of known ICT heads' (seed 1)
        by 0.95 mm; with 880 by 0.91 and 1.09 mm.
    fitted_spot : float, mm^2
        The same for a person whose head was fitted in this clip: errors of its shape reach
        farther. A speaker's own face counts as known: lips of eight films of ICT heads in another
        light are off by 1.86 mm with 220, 1.90 with 440 and 1.95 with 880. Chosen
        among 220, 880 and 3500 on films of unknown ICT heads (seeds 61 and 62), whose lips' motion
        is off by 1.00, 0.96, 1.01 and 0.86, 0.80, 0.85 mm, and on p01 to p08 of the strangers'
        clips.
    """

    least_motion: float = 1.0
    together: int = 9
    facing: float = 0.35
    margin: int = 16
    smoothing: float = 0.7
    rounds: int = 10
    wrong: float = 2.0
    least_light: float = 1e-6
    alike: float = 0.5
    least_noise: float = 0.001
    fewest: int = 10
    tail: float = 2.0
    brightness: tuple[float, float] = (0.25, 4.0)
    own_light: int = 4
    spot: float = 220.0
    fitted_spot: float = 880.0


SHADING = ShadingSettings()
