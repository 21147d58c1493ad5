"""Newton steps on what borders gain, then a simplex along the axes of what is left.

A step knows where every drawn border would rather be, so that a few drawings do what a simplex
needs hundreds for. Long lines first: they see past a wrong border; short ones last.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.objective import Batched
from abs_engine.core.params import ParamSpec
from abs_engine.optimise.axes import along_axes
from abs_engine.optimise.base import Solution, unit_of
from abs_engine.optimise.history import CONVERGED, LIMIT, checked_start
from abs_engine.optimise.settings import SOLVING

_RIDGE = 1e-9  # of the largest curvature: some directions may say nothing


class Curved(Batched, Protocol):
    """An objective that knows its slope and curvature."""

    def newton(
        self, x: FloatArray, reach: int, local: bool = False
    ) -> tuple[float, FloatArray, FloatArray]:
        """Value, gradient (N,) and second derivative (N, N) at `x` (N,)."""
        ...


@dataclass(frozen=True)
class Newton:
    """Minimise by Newton steps, and Nelder-Mead along their axes.

    Parameters
    ----------
    gain : float
        Steps end where one gains less, and one that promises less is not tried; in the objective's
        units.
    tolerance : float
        Where the simplex stops, in the objective's units.
    limit : int
        Largest number of evaluations.
    polished : int
        Of these, for the simplex, which has the last word along the axes that are least certain; 0
        leaves it out.
    starts : int
        Of several starts, how many of the best are descended from.
    reaches : tuple of int
        Drawn pixels to either side of a border that are looked at, step after step; the last step
        takes the slopes where borders are.
    more : float
        A step that gains so much is followed by another as long, in the objective's units.

    Notes
    -----
    On 40 frames each of p02, p05, p07 of the strangers' clips and of lrwp9a of GRID, values end
    0.01 nats above to 0.25 below those of three tries of every step, with 7 to 18 drawings for 19
    to 23. The simplex gains 0 to 0.02 nats in 8 drawings, and up to 0.05 in 16.
    """

    gain: float = SOLVING.newton_gain
    tolerance: float = SOLVING.tolerance
    limit: int = SOLVING.newton_limit
    polished: int = SOLVING.polished
    starts: int = 1
    reaches: tuple[int, ...] = SOLVING.newton_reaches
    more: float = SOLVING.newton_more

    def minimise(
        self, objective: Curved, start: FloatArray, spec: ParamSpec, _step: float = 1.0
    ) -> Solution:
        """Minimise from `start`; parameters and errors as `by_nlopt.Simplex.minimise`.

        Raises `ParameterError` also if the objective knows no borders.
        """
        first = checked_start(start, spec)
        found = self.descend(objective, first, spec, self.limit)
        return self.polish(objective, found, spec, first, self.limit - found.n_evaluations)

    def descend(
        self,
        objective: Curved,
        start: FloatArray,
        spec: ParamSpec,
        limit: int,
        *,
        free: bool = False,
    ) -> Solution:
        """The Newton steps from `start` (N,) within so many evaluations."""
        if not hasattr(objective, "newton"):
            raise ParameterError("the objective knows no borders", "choose another driver")
        x, damping, k, unit = spec.clip(start), 0.0, 0, unit_of(objective)
        made = objective.newton(x, self.reaches[0])
        trace, end = [made[0]], len(self.reaches) - 1
        while len(trace) < limit:
            last, reach = k >= end, self.reaches[min(k + 1, end)]
            before, (step, promised) = made[0], _step(made, damping)
            tries = SOLVING.newton_tries if promised >= self.gain * unit else 0
            for again in range(min(tries, limit - len(trace))):
                there = spec.clip(x + SOLVING.back**again * step)
                tried = objective.newton(there, reach, last)
                trace.append(tried[0])
                if tried[0] < before:
                    x, made = there, tried
                    break
            gain = before - made[0]
            if last and gain < self.gain * unit:
                break
            if gain < self.more * unit:
                k += 1
            if gain == 0 and len(trace) < limit:
                damping = max(SOLVING.damped_more * damping, SOLVING.damped) if tries else damping
                made = objective.newton(x, self.reaches[min(k, end)], k >= end)
                trace.append(made[0])
        status = LIMIT if len(trace) >= limit else CONVERGED
        scaled = 0.5 * made[2] * np.outer(spec.scale, spec.scale)
        return Solution(
            x, status, made[0], {}, len(trace), np.array(trace), len(trace), information=scaled
        )

    def polish(
        self, objective: Curved, found: Solution, spec: ParamSpec, centre: FloatArray, limit: int
    ) -> Solution:
        """Nelder-Mead along the axes of the curvature, from where a descent ended.

        It has so few evaluations that it seldom ends by itself; the status is the descent's.
        """
        most, tolerance = min(limit, self.polished), self.tolerance * unit_of(objective)
        best = along_axes(objective.values, found, spec, tolerance, most, edge=SOLVING.polish_edge)
        return replace(best, status=found.status)


def _step(made: tuple[float, FloatArray, FloatArray], damping: float) -> tuple[FloatArray, float]:
    """A Newton step (N,), and by how much the value would fall if the curvature were all."""
    _, slope, curve = made
    diagonal, ridged = np.diag(curve), curve.copy()
    np.fill_diagonal(ridged, diagonal + (damping * diagonal + _RIDGE * diagonal.max()))
    step = np.asarray(-np.linalg.solve(ridged, slope), np.float64)
    return step, -float(slope @ step + 0.5 * step @ curve @ step)
