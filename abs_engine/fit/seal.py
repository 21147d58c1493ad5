"""A decision about lips that were found a little apart: closed and parted are compared.

A picture hardly shows a gap of half a millimetre. Two cases are compared where a search has ended:
the lips touch, which they do in a share w of all frames, the speaker's or anybody's, or they are
open by the gap that was found, all gaps up to the widest being equally probable. Lips touch unless
the picture is against it by more than log(w / (1 - w) * widest / RESOLUTION).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.fit.problem import Problem
from abs_engine.fit.search import Found

FloatArray = NDArray[np.float64]
RESOLUTION = 0.5
"""mm: gaps that differ by less are not distinguished in a picture."""
OPEN_FROM = 3.0
"""mm: lips that are farther apart than that are open. It hardly matters: with 5 mm the picture is
against it in all but 2 of 61 frames of six real clips whose lips are 1 to 5 mm apart."""
USUAL, USUAL_GAP = 0.25, 15.0
"""Share of frames in which anybody's lips touch in speech, and mm by which they part at most; both
assumed. Gaps of closed lips become 0 in GRID's labelled clips, and precision and recall stay."""


@dataclass(frozen=True, eq=False)
class Seal:
    """Frequency with which lips touch.

    Parameters
    ----------
    gap : float, mm
        Between the middles of the inner lips, with all parameters zero.
    slope : (N,) float64, mm per unit of parameter
    worth : float, nats
        By how much touching lips are more probable beforehand than those with a certain gap.
    """

    gap: float
    slope: FloatArray
    worth: float

    @classmethod
    def of(cls, gap: float, slope: FloatArray, seen: FloatArray, closed: float) -> Seal | None:
        """Of postures that were seen; none if all of them, or none, are closed.

        Parameters
        ----------
        gap : float, mm
        slope : (N,) float64
        seen : (K, P) float64
            Values of the last P parameters.
        closed : float, mm
            The gap below which lips are taken to touch.
        """
        gaps = gap + seen @ slope[-seen.shape[1] :]
        share = float((gaps < closed).mean())
        if not 0 < share < 1:
            return None
        return cls(gap, slope, float(np.log(share / (1 - share) * gaps.max() / RESOLUTION)))

    @classmethod
    def usual(cls, gap: float, slope: FloatArray) -> Seal:
        """Of anybody's lips (`gap`, `slope`), which touch as often as people's do in speech."""
        return cls(gap, slope, float(np.log(USUAL / (1 - USUAL) * USUAL_GAP / RESOLUTION)))

    def apart(self, x: FloatArray) -> float:
        """The gap, mm, at parameters (N,)."""
        return float(self.gap + self.slope @ x)

    def closed(self, x: FloatArray) -> FloatArray:
        """The nearest parameters (N,) at which the lips touch."""
        return np.asarray(x - self.apart(x) / (self.slope @ self.slope) * self.slope)


def sealed(problem: Problem, found: Found, seal: Seal) -> Found:
    """Result over all parameters, or the same with lips that touch."""
    if not 0 < seal.apart(found.x) < OPEN_FROM:
        return found
    there = seal.closed(found.x)
    value = problem(problem.chosen(there)).value
    best = replace(found.best, n_evaluations=found.best.n_evaluations + 1)
    if value - found.best.value > seal.worth:
        return replace(found, best=best)
    return replace(found, x=there, best=replace(best, x=there, value=value))
