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
    alone : float, share of each component's noise
        That is taken for its own: a few dozen frames cannot tell that of hundreds of components
        from noise that they have in common. Not measured.
    highest : float, leverage
        Of a frame at most: one that alone decides about an item has nearly 1. Not
        measured.
    common : int
        Directions of common noise that are kept. Not measured.
    least_own : float, share of the variance
        That counts as not common, where few frames hold no more. Not measured.
    frames_each : int, frames
        For each number fitted at least, where what is left says how uncertain a texel is. Not
        measured.
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
    alone: float = 0.05
    highest: float = 0.95
    common: int = 6
    least_own: float = 0.1
    frames_each: int = 2
    window_step: float = 1.25
    window_reach: float = 2.0
    beside: float = 0.1
    doubt: float = 0.03


APPEARANCE = AppearanceSettings()
