"""Solvers of NLopt: the downhill simplex, and others without derivatives to compare it with."""

from __future__ import annotations

from dataclasses import dataclass

import nlopt
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.objective import Objective
from abs_engine.core.params import ParamSpec
from abs_engine.optimise.base import Solution, unit_of
from abs_engine.optimise.history import CONVERGED, LIMIT, History, LimitReachedError, checked_start
from abs_engine.optimise.settings import SOLVING


def run(solver: nlopt.opt, start: FloatArray, history: History) -> Solution:
    """Run a solver whose objective is counted by `history`; the best of what it saw.

    Raises `RuntimeError` if NLopt fails before the first evaluation.
    """
    try:
        solver.optimize(start)
    except LimitReachedError:
        return history.solution(LIMIT)
    except nlopt.RoundoffLimited:
        return history.solution(CONVERGED)
    except RuntimeError as error:
        if not len(history):
            raise
        return history.solution(f"failed: {error}")
    return history.solution(CONVERGED)


@dataclass(frozen=True)
class Simplex:
    """Minimise without derivatives from an initial simplex of the parameters' own scales.

    Parameters
    ----------
    tolerance : float
        Stop when the simplex's values differ by less than this, in the objective's units.
    limit : int
        Largest number of evaluations.

    Notes
    -----
    The start is a vertex of the first simplex. From there each parameter takes a step up, or down
    where a bound is near, for one vertex more; NLopt takes these steps from the best vertex so far.
    """

    tolerance: float = SOLVING.usual_tolerance
    limit: int = SOLVING.limit

    def minimise(
        self, objective: Objective, start: NDArray[np.float64], spec: ParamSpec, step: float = 1.0
    ) -> Solution:
        """Minimise from `start`.

        Parameters
        ----------
        objective : callable
            Given a vector (N,), returns an `Evaluation`.
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
        first, history = checked_start(start, spec), History(objective, self.limit)
        solver = nlopt.opt(nlopt.LN_NELDERMEAD, len(spec))
        solver.set_min_objective(lambda x, _gradient: history(x))
        solver.set_lower_bounds(spec.lower)
        solver.set_upper_bounds(spec.upper)
        solver.set_initial_step(step * spec.scale)
        solver.set_ftol_abs(self.tolerance * unit_of(objective))
        return run(solver, first, history)


METHODS = {
    "sbplx": nlopt.LN_SBPLX,
    "bobyqa": nlopt.LN_BOBYQA,
    "cobyla": nlopt.LN_COBYLA,
    "praxis": nlopt.LN_PRAXIS,
}


@dataclass(frozen=True)
class DerivativeFree:
    """Minimise by a method of NLopt, in units of the first steps.

    Parameters
    ----------
    method : str
        Of `METHODS`: Sbplx (simplices in subspaces), BOBYQA (quadratic models), COBYLA (linear
        ones) or PRAXIS (principal axes).
    tolerance : float
        Stop when the value changes by less than this, in the objective's units, as the method
        understands it.
    limit : int
        Largest number of evaluations.

    Raises
    ------
    ParameterError
        If there is no such method.
    """

    method: str
    tolerance: float = SOLVING.usual_tolerance
    limit: int = SOLVING.limit

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise ParameterError(
                f"there is no method '{self.method}'", f"choose one of {', '.join(METHODS)}"
            )

    def minimise(
        self, objective: Objective, start: FloatArray, spec: ParamSpec, step: float = 1.0
    ) -> Solution:
        """Minimise from `start`; parameters and errors as `Simplex.minimise`."""
        first, unit = checked_start(start, spec), step * spec.scale
        history = History(objective, self.limit)

        def value(z: FloatArray, _gradient: FloatArray) -> float:
            return history(spec.clip(first + unit * z))

        solver = nlopt.opt(METHODS[self.method], len(spec))
        solver.set_min_objective(value)
        solver.set_lower_bounds((spec.lower - first) / unit)
        solver.set_upper_bounds((spec.upper - first) / unit)
        solver.set_initial_step(np.ones(len(spec)))
        solver.set_ftol_abs(self.tolerance * unit_of(objective))
        return run(solver, np.zeros(len(spec)), history)
