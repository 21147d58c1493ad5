"""Running an NLopt solver: how it ends, and what is kept of it."""

from __future__ import annotations

import nlopt

from abs_engine.core.arrays import FloatArray
from abs_engine.optimise.base import Solution
from abs_engine.optimise.history import CONVERGED, LIMIT, History, LimitReachedError


def run(solver: nlopt.opt, start: FloatArray, history: History) -> Solution:
    """Run a solver whose objective is counted by `history`; the best of what it saw.

    Raises
    ------
    RuntimeError
        If NLopt fails before the first evaluation.
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
