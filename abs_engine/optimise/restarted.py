"""The simplex begun again where it ended, as long as that helps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.objective import Objective
from abs_engine.core.params import ParamSpec
from abs_engine.optimise.base import Solution, unit_of
from abs_engine.optimise.by_nlopt import Simplex
from abs_engine.optimise.history import LIMIT
from abs_engine.optimise.settings import SOLVING


@dataclass(frozen=True)
class RestartedSimplex:
    """Nelder-Mead with fresh simplices: one that has collapsed in a valley is no minimum.

    Press et al., Numerical Recipes in C, 10.4: "it is frequently a good idea to restart a
    multidimensional minimization routine at a point where it claims to have found a minimum".

    Parameters
    ----------
    tolerance : float
        Each simplex stops when its values differ by less than this, in the objective's units; the
        whole, when a restart gains less.
    limit : int
        Largest number of evaluations, of all together.
    restarts : int
        At most.
    """

    tolerance: float = SOLVING.usual_tolerance
    limit: int = SOLVING.limit
    restarts: int = 2

    def minimise(
        self, objective: Objective, start: FloatArray, spec: ParamSpec, step: float = 1.0
    ) -> Solution:
        """Minimise from `start`; parameters and errors as `Simplex.minimise`."""
        best = Simplex(self.tolerance, self.limit).minimise(objective, start, spec, step)
        trace, spent = [best.trace], best.n_evaluations
        for _ in range(self.restarts):
            if spent >= self.limit:
                break
            again = Simplex(self.tolerance, self.limit - spent)
            found = again.minimise(objective, best.x, spec, step)
            trace.append(found.trace)
            spent += found.n_evaluations
            gain = best.value - found.value
            best = found if gain > 0 else best
            if gain < self.tolerance * unit_of(objective):
                break
        status = LIMIT if spent >= self.limit else best.status
        return Solution(best.x, status, best.value, best.terms, spent, np.concatenate(trace))
