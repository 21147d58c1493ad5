"""Two drivers that climb: by forces (seed 000, eqs. 11-13) and by the gradient in parameter space.

Both walk: from where they are they ask for a direction, try it, lengthen the stride when the value
falls and shorten it when it does not. They differ in where the direction comes from. The forces
cost one drawing for a direction, whatever the number of parameters; the gradient costs two for each
parameter, drawn in one batch, and is the alternative that the paper leaves for later.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from abs_engine.objective import Evaluation, Objective
from abs_engine.optimise.base import Solution
from abs_engine.optimise.history import CONVERGED, LIMIT, checked_start
from abs_engine.params import ParamSpec

Vector = NDArray[np.float64]
_LONGER, _SHORTER = 1.5, 0.4
_SHORTEST = 0.02  # of the first stride: nothing more is to be found in this direction


class Pushed(Objective, Protocol):
    """An objective that knows which way forces push the parameters."""

    def push(self, x: Vector) -> Vector:
        """Change of the parameters (N,) under the forces at `x`; its length is a first stride."""
        ...


class Batched(Objective, Protocol):
    """An objective that is evaluated at many vectors at once."""

    def values(self, vectors: Vector) -> Vector:
        """Values (B,) at vectors (B, N)."""
        ...


@dataclass(frozen=True)
class Forces:
    """Follow the forces until they lead nowhere better.

    Parameters
    ----------
    tolerance : float
        Stop when an accepted step improves the value by less than this (absolute).
    limit : int
        Largest number of iterations: directions that are asked for.
    """

    tolerance: float = 0.02
    limit: int = 15

    def minimise(self, objective: Pushed, start: Vector, spec: ParamSpec) -> Solution:
        """Minimise from `start`.

        Parameters
        ----------
        objective : Pushed
        start : (N,) float64
        spec : ParamSpec
            Bounds; a step is no longer than ten of its scales in any parameter.

        Returns
        -------
        Solution
            `n_evaluations` counts values, and one drawing for each direction.

        Raises
        ------
        ParameterError
            If `start` is not finite or has another length than `spec`.
        """
        return _climb(objective, objective.push, start, spec, self.tolerance, self.limit, 1)


@dataclass(frozen=True)
class Gradient:
    """Steepest descent in parameters measured by their scales, from central differences.

    Parameters
    ----------
    tolerance : float
        Stop when an accepted step improves the value by less than this (absolute).
    limit : int
        Largest number of iterations.
    reach : float
        Difference step, in scales. A drawing changes by whole pixels, so it may not be small.
    """

    tolerance: float = 0.02
    limit: int = 30
    reach: float = 0.5

    def minimise(self, objective: Batched, start: Vector, spec: ParamSpec) -> Solution:
        """Minimise from `start`; see `Forces.minimise`. `n_evaluations` counts the differences."""

        def downhill(x: Vector) -> Vector:
            step = np.diag(self.reach * spec.scale)
            values = objective.values(np.vstack([x + step, x - step]))
            slope = (values[: len(x)] - values[len(x) :]) / (2 * self.reach)  # per scale
            steepest = np.linalg.norm(slope)
            return -spec.scale * slope / steepest if steepest > 0 else np.zeros_like(x)

        return _climb(objective, downhill, start, spec, self.tolerance, self.limit, 2 * len(spec))


class _Direction(Protocol):
    def __call__(self, x: Vector) -> Vector: ...


def _climb(
    objective: Objective,
    direction: _Direction,
    start: Vector,
    spec: ParamSpec,
    tolerance: float,
    limit: int,
    cost: int,
) -> Solution:
    """Walk along `direction`, whose every call costs `cost` evaluations."""
    x = checked_start(start, spec)
    best = objective(x)
    trace, spent, stride = [best.value], 1, 1.0
    for iteration in range(1, limit + 1):
        way = _bounded(direction(x), spec)
        spent += cost
        found: Evaluation | None = None
        while found is None and stride >= _SHORTEST and way.any():
            there = spec.clip(x + stride * way)
            tried = objective(there)
            spent += 1
            trace.append(tried.value)
            if tried.value < best.value:
                found = tried
            else:
                stride *= _SHORTER
        if found is None:
            return _ended(x, CONVERGED, best, spent, trace, iteration)
        gain, x, best = best.value - found.value, there, found
        stride *= _LONGER
        if gain < tolerance:
            return _ended(x, CONVERGED, best, spent, trace, iteration)
    return _ended(x, LIMIT, best, spent, trace, limit)


def _ended(
    x: Vector, status: str, best: Evaluation, spent: int, trace: list[float], iterations: int
) -> Solution:
    return Solution(x, status, best.value, best.terms, spent, np.array(trace), iterations)


def _bounded(way: Vector, spec: ParamSpec) -> Vector:
    """A direction, shortened so that no parameter moves by more than ten of its scales."""
    longest = float(np.abs(way / spec.scale).max(initial=0.0))
    return way if longest <= 10 else way * (10 / longest)
