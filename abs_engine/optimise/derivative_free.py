"""NLopt's other methods without derivatives, for comparison with the simplex."""

from __future__ import annotations

from dataclasses import dataclass

import nlopt
import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.objective import Objective
from abs_engine.core.params import ParamSpec
from abs_engine.optimise.base import Solution, unit_of
from abs_engine.optimise.by_nlopt import run
from abs_engine.optimise.history import History, checked_start
from abs_engine.optimise.settings import SOLVING

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
        """Minimise from `start`; parameters and errors as `simplex.Simplex.minimise`."""
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
