"""The history that every derivative-free solver keeps of its evaluations."""

from __future__ import annotations

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.objective import Evaluation, Objective
from abs_engine.core.params import ParamSpec
from abs_engine.optimise.base import Solution

LIMIT, CONVERGED = "evaluation limit", "converged"


class LimitReachedError(Exception):
    """A solver asked for one more evaluation than it may have; caught by the solver itself."""


class History:
    """Calls an objective, remembers the best value and the trace, and stops at a limit."""

    def __init__(self, objective: Objective, limit: int) -> None:
        self._objective, self._limit = objective, limit
        self._trace: list[float] = []
        self._best: Evaluation | None = None
        self._x: FloatArray | None = None

    def __call__(self, x: FloatArray) -> float:
        """The value at `x`."""
        if len(self._trace) >= self._limit:
            raise LimitReachedError
        evaluation = self._objective(x)
        self._trace.append(evaluation.value)
        if self._best is None or evaluation.value < self._best.value:
            self._best, self._x = evaluation, np.array(x, np.float64)
        return evaluation.value

    def __len__(self) -> int:
        """Return the number of evaluations."""
        return len(self._trace)

    def solution(self, status: str, iterations: int = 0) -> Solution:
        """The best of what was seen."""
        if self._best is None or self._x is None:
            raise ParameterError("the objective was never evaluated", "raise the evaluation limit")
        return Solution(
            self._x, status, self._best.value, self._best.terms, len(self._trace),
            np.array(self._trace), iterations,
        )  # fmt: skip


def checked_start(start: FloatArray, spec: ParamSpec) -> FloatArray:
    """The start within the bounds; `ParameterError` if it is not finite, or not of their number."""
    if start.shape != (len(spec),) or not np.isfinite(start).all():
        raise ParameterError(
            f"the start has shape {start.shape} or is not finite", f"give {len(spec)} numbers"
        )
    return spec.clip(start)
