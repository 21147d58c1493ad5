"""A decision about lips that were found a little apart: closed and parted are compared.

A picture hardly shows a gap of half a millimetre. Two cases are compared where a search has ended:
the lips touch, which they do in a share w of all frames, the speaker's or anybody's, or they are
open by the gap that was found, all gaps up to the widest being equally probable. Lips touch unless
the picture is against it by more than log(w / (1 - w) * widest / RESOLUTION).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.fit.problem import Problem
from abs_engine.fit.search import Found
from abs_engine.fit.settings import HEAD_FIT


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

        `seen` (K, P) are values of the last P parameters; `closed`, mm, is the gap below which lips
        are taken to touch.
        """
        gaps = gap + seen @ slope[-seen.shape[1] :]
        share = float((gaps < closed).mean())
        if not 0 < share < 1:
            return None
        return cls(gap, slope, _worth(share, float(gaps.max())))

    @classmethod
    def usual(cls, gap: float, slope: FloatArray) -> Seal:
        """Of anybody's lips (`gap`, `slope`), which touch as often as people's do in speech."""
        return cls(gap, slope, _worth(HEAD_FIT.usually_closed, HEAD_FIT.usual_gap))

    def apart(self, x: FloatArray) -> float:
        """The gap, mm, at parameters (N,)."""
        return float(self.gap + self.slope @ x)

    def closed(self, x: FloatArray) -> FloatArray:
        """The nearest parameters (N,) at which the lips touch."""
        return np.asarray(x - self.apart(x) / (self.slope @ self.slope) * self.slope)


def _worth(share: float, widest: float) -> float:
    """Log odds, nats, of lips that touch in a share of frames and part by `widest` mm at most."""
    return float(np.log(share / (1 - share) * widest / HEAD_FIT.resolution))


def sealed(problem: Problem, found: Found, seal: Seal) -> Found:
    """Result over all parameters, or the same with lips that touch."""
    if not 0 < seal.apart(found.x) < HEAD_FIT.open_from:
        return found
    there = _touching(problem, found.x, seal)
    value = problem(problem.chosen(there)).value
    best = replace(found.best, n_evaluations=found.best.n_evaluations + 1)
    if value - found.best.value > seal.worth:
        return replace(found, best=best)
    return replace(found, x=there, best=replace(best, x=there, value=value))


def _touching(problem: Problem, x: FloatArray, seal: Seal) -> FloatArray:
    """Parameters (6 + P,) near `x` at which the lips touch.

    Where evidence holds the skin in its place, those that cost least, about.
    """
    if not any(getattr(term, "holds_skin", False) for term in problem.terms.values()):
        return seal.closed(x)
    told, slope = problem.information(problem.chosen(x)), problem.chosen(seal.slope)
    if told is None:
        return seal.closed(x)
    way = np.linalg.lstsq(told, slope, rcond=None)[0]
    if not slope @ way > 0:
        return seal.closed(x)
    return problem.whole(problem.chosen(x) - seal.apart(x) / (slope @ way) * way)
