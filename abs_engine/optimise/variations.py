"""Local variations: one parameter after the other is varied, and what is better is kept."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.objective import Objective
from abs_engine.core.params import ParamSpec
from abs_engine.optimise.base import Solution, unit_of
from abs_engine.optimise.history import CONVERGED, LIMIT, History, LimitReachedError, checked_start
from abs_engine.optimise.settings import SOLVING


@dataclass(frozen=True)
class LocalVariations:
    """Minimise by varying one parameter at a time, both ways, by steps that become smaller.

    The method that Odisio and Bailly (2003), section 4, compare with by name only. Here a step
    that helped is tried first the same way the next time and is made larger; one that helped
    neither way is halved.

    Parameters
    ----------
    tolerance : float
        Stop when a round over all parameters gains less than this, in the objective's units, and
        the next, with smaller steps, as well.
    limit : int
        Largest number of evaluations.
    """

    tolerance: float = SOLVING.usual_tolerance
    limit: int = SOLVING.limit

    def minimise(
        self, objective: Objective, start: FloatArray, spec: ParamSpec, step: float = 1.0
    ) -> Solution:
        """Minimise from `start`; parameters and errors as `by_nlopt.Simplex.minimise`."""
        x = checked_start(start, spec)
        history = History(objective, self.limit)
        rounds = 0
        try:
            steps, value, idle = step * spec.scale, history(x), 0
            while idle < 2:
                before = value
                x, value, steps = _round(history, x, value, steps, spec)
                rounds += 1
                idle = idle + 1 if before - value < self.tolerance * unit_of(objective) else 0
        except LimitReachedError:
            return history.solution(LIMIT, rounds)
        return history.solution(CONVERGED, rounds)


def _round(
    history: History, x: FloatArray, value: float, steps: FloatArray, spec: ParamSpec
) -> tuple[FloatArray, float, FloatArray]:
    """Vary every parameter once; the place, its value and the next steps (signed)."""
    x, steps = x.copy(), steps.copy()
    for k in range(len(x)):
        for move in (steps[k], -steps[k]):
            tried = x.copy()
            tried[k] = np.clip(x[k] + move, spec.lower[k], spec.upper[k])
            if tried[k] == x[k]:
                continue
            found = history(tried)
            if found < value:
                x, value, steps[k] = tried, found, SOLVING.longer * move
                break
        else:
            steps[k] /= 2
    return x, value, steps
