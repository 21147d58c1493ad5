"""Nelder-Mead's downhill simplex, by NLopt."""

from __future__ import annotations

from dataclasses import dataclass

import nlopt
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.objective import Objective
from abs_engine.core.params import ParamSpec
from abs_engine.optimise.base import Solution, unit_of
from abs_engine.optimise.by_nlopt import run
from abs_engine.optimise.history import History, checked_start
from abs_engine.optimise.settings import SOLVING


@dataclass(frozen=True)
class Simplex:
    """Minimise without derivatives from an initial simplex of the parameters' own scales.

    Parameters
    ----------
    tolerance : float
        Stop when the simplex's values differ by less than this, in the objective's units.
    limit : int
        Largest number of evaluations.
    """

    tolerance: float = SOLVING.usual_tolerance
    limit: int = SOLVING.limit

    def minimise(
        self, objective: Objective, start: NDArray[np.float64], spec: ParamSpec, step: float = 1.0
    ) -> Solution:
        """Minimise from `start`.

        Parameters
        ----------
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
