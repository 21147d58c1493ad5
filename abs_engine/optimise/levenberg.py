"""Levenberg-Marquardt on sums of squares, their slopes by differences."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.params import ParamSpec
from abs_engine.optimise.anchored import Held, Quadratic, check_quadratic
from abs_engine.optimise.base import Solution
from abs_engine.optimise.history import CONVERGED, LIMIT, checked_start
from abs_engine.optimise.settings import SOLVING


@dataclass(frozen=True)
class LevenbergMarquardt:
    """Minimise a sum of squares by damped Gauss-Newton steps (Marquardt 1963).

    Parameters
    ----------
    tolerance : float
        Stop when a step gains less than this, in the objective's units.
    limit : int
        Largest number of evaluations, those for slopes counted.
    difference : float
        Step of the differences, in first steps of the parameters.
    steps : int
        Largest number of steps.
    tries : int
        Largest number of dampings that are tried for a step.
    """

    tolerance: float = SOLVING.squares_tolerance
    limit: int = SOLVING.limit
    difference: float = SOLVING.squares_difference
    steps: int = SOLVING.squares_steps
    tries: int = SOLVING.squares_tries

    def minimise(
        self, objective: Quadratic, start: FloatArray, spec: ParamSpec, step: float = 1.0
    ) -> Solution:
        """Minimise from `start`; parameters and errors as `by_nlopt.Simplex.minimise`.

        Raises `ParameterError` also if the objective has no residuals.
        """
        check_quadratic(objective)
        first = checked_start(start, spec)
        return self.descend(Held(objective, spec, first), first, self.limit, step)

    def descend(self, held: Held, x: FloatArray, limit: int, step: float = 1.0) -> Solution:
        """Minimise from `x` (n,) within so many evaluations; `information` is the last matrix.

        The trace has the values with the pull, `value` is without.
        """
        spec, damping, spent = held.spec, SOLVING.damping, 0
        value, matrix, trace = np.inf, None, list[float]()
        status, taken = LIMIT, 0
        for _ in range(self.steps):
            if spent + len(x) + 1 + (self.tries if spent else 1) > limit:
                break
            value, matrix, gradient = held.gauss_newton(x, self.difference * step)
            spent += len(x) + 1
            trace.append(value)
            taken += 1
            for _try in range(min(self.tries, limit - spent)):
                stiff = matrix + damping * np.diag(np.diag(matrix) + 1e-12)
                y = spec.clip(x - np.linalg.solve(stiff, gradient) * spec.scale)
                new = float(held.values(y[None])[0])
                spent += 1
                trace.append(new)
                if new < value:
                    break
                damping = SOLVING.stiffer * max(damping, SOLVING.stiffened)
            if not new < value:
                status = CONVERGED
                break
            gain, x, value = value - new, y, new
            damping = max(damping / SOLVING.stiffer, SOLVING.least_damping)
            if gain < self.tolerance * held.unit:
                status = CONVERGED
                break
        if not trace:
            value, spent = float(held.values(x[None])[0]), 1
            trace.append(value)
        value -= float(held.pull(x))
        return Solution(x, status, value, {}, spent, np.array(trace), taken, matrix)
