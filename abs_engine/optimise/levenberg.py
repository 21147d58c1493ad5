"""Levenberg-Marquardt on residuals, their Jacobian by differences."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import ParameterError
from abs_engine.core.objective import Evaluation
from abs_engine.core.params import ParamSpec
from abs_engine.optimise.base import Solution
from abs_engine.optimise.history import (
    CONVERGED,
    LIMIT,
    History,
    LimitReachedError,
    checked_start,
)

FloatArray = NDArray[np.float64]
_LEAST, _MOST = 1e-9, 1e9  # of the damping


class Residuals(Protocol):
    """An objective that is a sum of squares."""

    def __call__(self, x: FloatArray) -> Evaluation:
        """The value that is reported of `x`."""
        ...

    def residuals(self, x: FloatArray) -> FloatArray:
        """What is squared and summed at `x`, (M,); M and the meaning of each stay the same."""
        ...


@dataclass(frozen=True)
class LevenbergMarquardt:
    """Minimise a sum of squares by damped Gauss-Newton steps (Marquardt 1963).

    Parameters
    ----------
    tolerance : float
        Stop when a step gains less than this (absolute).
    limit : int
        Largest number of evaluations, those for the Jacobian counted.
    difference : float
        Step of the differences, in first steps of the parameters.
    """

    tolerance: float = 0.02
    limit: int = 400
    difference: float = 0.2

    def minimise(
        self, objective: Residuals, start: FloatArray, spec: ParamSpec, step: float = 1.0
    ) -> Solution:
        """Minimise from `start`; parameters and errors as `simplex.Simplex.minimise`.

        Raises
        ------
        ParameterError
            Also if the objective has no residuals.
        """
        if not hasattr(objective, "residuals"):
            raise ParameterError("the objective has no residuals", "choose another solver")
        x = checked_start(start, spec)
        walk = _Walk(objective, spec, self.difference * step * spec.scale, self.limit)
        try:
            return walk.run(x, self.tolerance)
        except LimitReachedError:
            return walk.history.solution(LIMIT, walk.iterations)


class _Walk:
    """One minimisation."""

    def __init__(self, objective: Residuals, spec: ParamSpec, move: FloatArray, limit: int) -> None:
        self._objective, self._spec, self._move = objective, spec, move
        self._last = np.zeros(0)
        self.history = History(self._evaluate, limit)
        self.iterations = 0

    def _evaluate(self, x: FloatArray) -> Evaluation:
        self._last = self._objective.residuals(x)
        return Evaluation(float(self._last @ self._last))

    def run(self, x: FloatArray, tolerance: float) -> Solution:
        value, damping, idle = self.history(x), 1e-2, 0
        here = self._last
        while True:
            jacobian = self._jacobian(x, here)
            normal, slope = jacobian.T @ jacobian, jacobian.T @ here
            self.iterations += 1
            while True:
                damped = normal + damping * np.diag(np.maximum(np.diag(normal), 1e-12))
                tried = self._spec.clip(x - np.linalg.solve(damped, slope))
                found = self.history(tried)
                if found < value or damping >= _MOST:
                    break
                damping *= 5.0
            gain = value - found
            if found < value:
                x, value, here = tried, found, self._last
                damping = max(damping / 10.0, _LEAST)
            idle = idle + 1 if gain < tolerance else 0
            if idle > 1 or damping >= _MOST:
                return self.history.solution(CONVERGED, self.iterations)

    def _jacobian(self, x: FloatArray, here: FloatArray) -> FloatArray:
        """Forward differences (M, N), away from the bound where one is near."""
        columns = []
        for k, move in enumerate(self._move):
            ahead = x[k] + move <= self._spec.upper[k]
            moved = x.copy()
            moved[k] += move if ahead else -move
            self.history(moved)
            columns.append((self._last - here) / (moved[k] - x[k]))
        return np.stack(columns, axis=1)
