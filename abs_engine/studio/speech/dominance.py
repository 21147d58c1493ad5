"""Coarticulation by dominance functions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from abs_engine.core.arrays import FloatArray

EXPONENT = 1.5
"""Power of time in the dominance functions; above 1 the curves have no corners."""


@dataclass(frozen=True, eq=False)
class Score:
    """Targets of S segments for A articulators, and how strongly and when they hold.

    Parameters
    ----------
    start, end : (S,) float64
        Seconds between which a segment's dominance is whole.
    target : (S, A) float64
    magnitude : (S, A) float64
        Of the dominance, above 0.
    rise, fall : (S, A) float64
        Seconds in which the dominance changes by a factor e, before `start` and after `end`.
    """

    start: FloatArray
    end: FloatArray
    target: FloatArray
    magnitude: FloatArray
    rise: FloatArray
    fall: FloatArray


def blend(score: Score, times: FloatArray) -> FloatArray:
    """Curves (T, A) of the articulators at `times` (T,), seconds.

    Each is the mean of the segments' targets, weighted with their dominance.

    Notes
    -----
    Equations 1 to 3 of Cohen, M. M. & Massaro, D. W. (1993), "Modeling coarticulation in synthetic
    visual speech": ``D = alpha exp(-theta |tau|^c)``, ``F(t) = sum(D T) / sum(D)``. Two departures:
    tau is counted from the edges of a span in which the segment holds, not from its middle, so
    that long sounds stand still; and c is 1.5, where they name 1.
    """
    before = np.maximum(score.start - times[:, None], 0.0)[..., None]
    after = np.maximum(times[:, None] - score.end, 0.0)[..., None]
    decay = (before / score.rise) ** EXPONENT + (after / score.fall) ** EXPONENT
    log_dominance = np.log(score.magnitude) - decay
    # Only ratios matter; the largest is made 1 so that nothing underflows in long pauses.
    dominance = np.exp(log_dominance - log_dominance.max(axis=1, keepdims=True))
    total = (dominance * score.target).sum(axis=1)
    return np.asarray(total / dominance.sum(axis=1), np.float64)
