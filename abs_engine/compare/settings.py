"""Settings of terms and priors."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class CompareSettings:
    """Settings of terms and priors.

    Attributes
    ----------
    least_curvature : float, probability per pixel
        Of a border, so that none goes too far. Not measured.
    kept : float, share of the pixels drawn at the start
        That must stay: lips that part and heads that move back draw somewhat fewer. Not measured.
    depth_scale : float, scale of the window
        Of the drawing that decides what is hidden. Not measured.
    contact_ahead : float, mm
        So far ahead contact stiffens a step already. Not measured.
    contact_softness : float, mm
        Depth by which lips pass into each other that is as improbable as one standard deviation.
        Not measured.
    """

    least_curvature: float = 0.02
    kept: float = 0.95
    depth_scale: float = 0.5
    contact_ahead: float = 0.15
    contact_softness: float = 0.6


COMPARISON = CompareSettings()
