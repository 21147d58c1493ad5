"""Nelder-Mead's downhill simplex, by NLopt; the only user of nlopt."""

from __future__ import annotations

from dataclasses import dataclass

import nlopt
import numpy as np
from numpy.typing import NDArray

from abs_engine.errors import ParameterError
from abs_engine.objective import Evaluation, Objective
from abs_engine.optimise.base import Solution
from abs_engine.params import ParamSpec


@dataclass(frozen=True)
class Simplex:
    """Minimise without derivatives from an initial simplex of the parameters' own scales.

    Parameters
    ----------
    tolerance : float
        Stop when the simplex's values differ by less than this (absolute).
    limit : int
        Largest number of evaluations.
    """

    tolerance: float = 0.02
    limit: int = 400

    def minimise(
        self, objective: Objective, start: NDArray[np.float64], spec: ParamSpec, step: float = 1.0
    ) -> Solution:
        """Minimise from `start`.

        Parameters
        ----------
        objective : Objective
        start : (N,) float64
            Moved into the bounds where it is outside.
        spec : ParamSpec
            Bounds, and the scale of the first simplex.
        step : float
            Factor on that scale.

        Raises
        ------
        ParameterError
            If `start` is not finite or has another length than `spec`.
        """
        if start.shape != (len(spec),) or not np.isfinite(start).all():
            raise ParameterError(
                f"the start has shape {start.shape} or is not finite", f"give {len(spec)} numbers"
            )
        record = _Record(objective)
        solver = nlopt.opt(nlopt.LN_NELDERMEAD, len(spec))
        solver.set_min_objective(record)
        solver.set_lower_bounds(spec.lower)
        solver.set_upper_bounds(spec.upper)
        solver.set_initial_step(step * spec.scale)
        solver.set_ftol_abs(self.tolerance)
        solver.set_maxeval(self.limit)
        try:
            solver.optimize(spec.clip(start))
            reached = solver.last_optimize_result() == nlopt.MAXEVAL_REACHED
            status = "evaluation limit" if reached else "converged"
        except nlopt.RoundoffLimited:
            status = "converged"
        except RuntimeError as error:
            if record.best is None:
                raise
            status = f"failed: {error}"
        return record.solution(status)


class _Record:
    """Calls the objective and remembers the best value and the trace."""

    def __init__(self, objective: Objective) -> None:
        self._objective = objective
        self._trace: list[float] = []
        self._x: NDArray[np.float64] | None = None
        self.best: Evaluation | None = None

    def __call__(self, x: NDArray[np.float64], _gradient: NDArray[np.float64]) -> float:
        evaluation = self._objective(x)
        self._trace.append(evaluation.value)
        if self.best is None or evaluation.value < self.best.value:
            self.best, self._x = evaluation, x.copy()
        return evaluation.value

    def solution(self, status: str) -> Solution:
        """The best of what was seen."""
        if self.best is None or self._x is None:
            raise ParameterError("the objective was never evaluated", "raise the evaluation limit")
        trace = np.array(self._trace)
        return Solution(self._x, status, self.best.value, self.best.terms, len(trace), trace)
