"""Postures in which lips meet lips, or lip meets teeth, on the mesh of the person who speaks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import lsq_linear

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.face.schema import Pair, Unit, units_of
from abs_engine.studio.speech.lips import Lips

Measure = Callable[[FloatArray], tuple[FloatArray, FloatArray]]

PRESS = 0.1
"""How much farther (mm) than at rest the lips overlap in a closure: lips press together in p."""
_SETTLED = 2e-3
"""Change of a weight below which a search ends: less than 0.1 mm for the strongest unit."""
TOUCH = 0.1
"""Distance (mm) of lip and teeth that a labiodental aims at."""


@dataclass(frozen=True)
class Use:
    """Use of a face unit that may help to make contact.

    Parameters
    ----------
    cost : float
        Millimetres of contact that may be missed rather than move it by 1.
    most : float
        Its largest weight, if the posture does not have more; 0: it may only be reduced.
    """

    cost: float
    most: float = 0.0


# Pairs left and right move together. Units that part the lips give way, cheap ones first.
_CLOSING: dict[str, Use] = {
    Unit.MOUTH_CLOSE: Use(0.20, 1.0),
    Unit.JAW_OPEN: Use(0.60),
    Pair.MOUTH_LOWER_DOWN: Use(0.08),
    Pair.MOUTH_UPPER_UP: Use(0.08),
    Unit.MOUTH_FUNNEL: Use(0.40),
    Unit.MOUTH_PUCKER: Use(0.80),
    Pair.MOUTH_SMILE: Use(0.80),
    Pair.MOUTH_STRETCH: Use(0.80),
    Pair.MOUTH_PRESS: Use(0.40, 0.5),
    Unit.MOUTH_ROLL_LOWER: Use(0.60, 0.4),
    Unit.MOUTH_ROLL_UPPER: Use(0.60, 0.3),
    Unit.MOUTH_SHRUG_LOWER: Use(1.60, 0.3),
    Unit.MOUTH_SHRUG_UPPER: Use(1.60, 0.2),
}
# The lips lie 6 to 10 mm before the teeth, by the person: a full roll, with the jaw low to draw the
# lip back and pressed corners to lift it again, is the way there. The
# farther a person's lips stand out, the lower goes the jaw and the tighter are the corners drawn;
# stretch, dimple and frown draw them back where a smile would lift them.
_BITING: dict[str, Use] = {
    Unit.JAW_OPEN: Use(0.10, 0.45),
    Unit.MOUTH_ROLL_LOWER: Use(0.01, 1.0),
    Pair.MOUTH_PRESS: Use(0.06, 1.0),
    Pair.MOUTH_SMILE: Use(0.10, 0.5),
    Pair.MOUTH_STRETCH: Use(0.10, 0.4),
    Pair.MOUTH_DIMPLE: Use(0.10, 0.4),
    Pair.MOUTH_FROWN: Use(0.10, 0.4),
    Pair.MOUTH_LOWER_DOWN: Use(0.10),
    Unit.MOUTH_PUCKER: Use(0.10),
    Unit.MOUTH_FUNNEL: Use(0.10),
    Unit.MOUTH_CLOSE: Use(0.10),
}
_AT_EASE: dict[str, float] = dict.fromkeys(
    (Pair.MOUTH_LOWER_DOWN, Unit.MOUTH_PUCKER, Unit.MOUTH_FUNNEL, Unit.MOUTH_CLOSE), 0.0
)
_LEADING = (Unit.JAW_OPEN, Unit.MOUTH_ROLL_LOWER, Pair.MOUTH_PRESS, Pair.MOUTH_SMILE)
_BITES = tuple(
    dict(zip(_LEADING, weights, strict=True)) | _AT_EASE
    for weights in ((0.24, 1.0, 0.7, 0.3), (0.34, 1.0, 0.9, 0.45), (0.28, 1.0, 0.9, 0.4))
)
"""Where searches for a bite start, until one is good; found by wide searches on many heads."""

_GOOD = 0.15
"""Root mean square (mm) of what a bite may miss, its cost included."""


@dataclass(frozen=True, eq=False)
class ContactSolver:
    """Moves a posture to the nearest one in which lips or lip and teeth touch.

    Parameters
    ----------
    lips : Lips
        Of the person.
    unit_names : tuple of str
        The 52 face units.
    """

    lips: Lips
    unit_names: tuple[str, ...]

    def close(self, weights: FloatArray) -> FloatArray:
        """Posture (52,) near `weights` whose lips are sealed as at rest, and pressed."""
        return self._solve(weights, self._unsealed, _CLOSING, steps=4, longest=1.0, start={})[0]

    def bite(self, weights: FloatArray) -> FloatArray:
        """Posture (52,) near `weights` in which the lower lip touches the upper front teeth."""
        best, least = weights, np.inf
        for start in _BITES:
            bitten, missed = self._solve(
                weights, self._unbitten, _BITING, steps=24, longest=0.03, start=start
            )
            if missed < least:
                best, least = bitten, missed
            if np.sqrt(least) < _GOOD:
                break
        return best

    @cached_property
    def biting_units(self) -> IntArray:
        """Indices of the face units that `bite` may change."""
        return np.flatnonzero(self._pattern(tuple(_BITING)).any(axis=1))

    @cached_property
    def _seal(self) -> FloatArray:
        """Gaps (C,) at rest, mm: all below 0, and far below where thick lips meet at the sides."""
        return self.lips.gaps(np.zeros(len(self.unit_names)))[0]

    def _unsealed(self, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
        gaps, slopes = self.lips.gaps(weights)
        across = np.linspace(0, 1, len(gaps))
        seal = np.interp(across, np.linspace(0, 1, len(self._seal)), self._seal)
        # Where thick lips overlap far anyway, a little more or less is of no account.
        care = np.exp(2.0 * (seal - self._seal.max()))
        return care * (gaps - seal + PRESS), care[:, None] * slopes

    def _unbitten(self, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
        gaps, slopes = self.lips.tooth_gaps(weights)
        return gaps - TOUCH, slopes

    def _solve(
        self,
        weights: FloatArray,
        measure: Measure,
        uses: Mapping[str, Use],
        *,
        steps: int,
        longest: float,
        start: Mapping[str, float],
    ) -> tuple[FloatArray, float]:
        """Gauss-Newton on a measure that should be 0: the posture, and its sum of squares.

        `longest` is the largest step of a unit; `start` has the weights that are started from,
        of units for which these are not the posture's.
        """
        pattern = self._pattern(tuple(uses))
        current = np.array([weights[row].max() for row in pattern.T > 0])
        least = -np.array([weights[row].min() for row in pattern.T > 0])
        most = np.maximum([use.most for use in uses.values()] - current, 0.0) + 1e-9
        cost = np.array([use.cost for use in uses.values()])
        change = np.array([start.get(n, c) for n, c in zip(uses, current, strict=True)]) - current
        change = np.clip(change, least, most)
        moved = pattern.any(axis=1)
        best, fewest = change, np.inf
        for step in range(steps + 1):
            miss, slopes = measure(weights + pattern @ change)
            miss, slopes = miss / np.sqrt(len(miss)), slopes / np.sqrt(len(miss))
            if (total := float(miss @ miss + np.square(cost * change).sum())) < fewest:
                best, fewest = change, total
            if step == steps:
                break
            slopes = slopes[:, moved] @ pattern[moved]
            bounds = np.maximum(least, change - longest), np.minimum(most, change + longest)
            design = np.vstack([slopes, np.diag(cost)])
            goal = np.concatenate([slopes @ change - miss, np.zeros(len(cost))])
            change, last = lsq_linear(design, goal, bounds, method="bvls").x, change
            if np.abs(change - last).max() < _SETTLED:
                break
        return np.asarray(np.clip(weights + pattern @ best, 0.0, 1.0), np.float64), fewest

    def _pattern(self, names: tuple[str, ...]) -> FloatArray:
        """Matrix (52, N) from the named movements to the units."""
        moved = [units_of(name) for name in names]
        return np.array([[unit in one for one in moved] for unit in self.unit_names], np.float64)
