"""A decision about lips that were found a little apart: closed and parted are compared.

A picture hardly shows a gap of half a millimetre. Two cases are compared where a search has ended:
the lips touch, which they do in a share w of all frames, the speaker's or anybody's, or they are
apart, all gaps up to the widest being equally probable beforehand. Of these the picture leaves a
band as wide as its uncertainty sd of the gap: the evidence for lips apart is, by Laplace's method,
the likelihood of the gap found times sqrt(2 pi) sd / widest (what of the band lies below 0, at most
half, is counted, too). So lips touch, in the posture in which that costs least, unless the picture
is against it by more than log(w / (1 - w) * widest / (sqrt(2 pi) sd)).
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
    odds : float, nats
        By how much touching lips are more probable beforehand than a band of gaps 1 mm wide.
    """

    gap: float
    slope: FloatArray
    odds: float

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
        return cls(gap, slope, _odds(share, float(gaps.max())))

    @classmethod
    def usual(cls, gap: float, slope: FloatArray) -> Seal:
        """Of anybody's lips (`gap`, `slope`), which touch as often as people's do in speech."""
        return cls(gap, slope, _odds(HEAD_FIT.usually_closed, HEAD_FIT.usual_gap))

    def apart(self, x: FloatArray) -> float:
        """The gap, mm, at parameters (N,)."""
        return float(self.gap + self.slope @ x)

    def closed(self, x: FloatArray) -> FloatArray:
        """The nearest parameters (N,) at which the lips touch."""
        return np.asarray(x - self.apart(x) / (self.slope @ self.slope) * self.slope)


def _odds(share: float, widest: float) -> float:
    """Log odds, nats, of lips that touch in a share of frames and part by `widest` mm at most."""
    return float(np.log(share / (1 - share) * widest))


def sealed(problem: Problem, found: Found, seal: Seal) -> Found:
    """Result over all parameters, or the same with lips that touch."""
    if not 0 < seal.apart(found.x) < HEAD_FIT.open_from:
        return found
    there, band = _touching(problem, found.x, seal)
    value = problem(problem.chosen(there)).value
    best = replace(found.best, n_evaluations=found.best.n_evaluations + 1)
    if value - found.best.value > seal.odds - np.log(band):
        return replace(found, best=best)
    return replace(found, x=there, best=replace(best, x=there, value=value))


def _touching(problem: Problem, x: FloatArray, seal: Seal) -> tuple[FloatArray, float]:
    """Parameters (6 + P,) near `x` at which the lips touch and that cost least, about.

    And the width, mm, of the band of gaps that the picture leaves. Where nothing says how the value
    bends, the nearest parameters, and `HEAD_FIT.resolution`.
    """
    told, slope = problem.information(problem.chosen(x)), problem.chosen(seal.slope)
    if told is not None:
        way = np.linalg.lstsq(told, slope, rcond=None)[0]
        variance = float(slope @ way)
        if variance > 0:
            nearest = problem.chosen(x) - seal.apart(x) / variance * way
            return problem.whole(nearest), float(np.sqrt(2 * np.pi * variance))
    return seal.closed(x), HEAD_FIT.resolution
