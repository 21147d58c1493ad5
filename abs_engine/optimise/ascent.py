"""Drivers that climb: by forces (Basu et al., eqs. 11-13) and by the gradient in parameters.

Both walk: from where they are they ask for a direction, look at several strides along it, drawn in
one batch, and go to the best. How far to go for the best is another question for a head's pose than
for its shape; where both are fitted, each stride of the one is tried with each of the other. Narrow
valleys make such walks zigzag; so each stride is also tried together with multiples of the step
before, which hold on to what successive directions agree in (a memory gradient). Where the
directions come from is what differs. The forces cost one drawing for a direction, whatever the
number of parameters; the gradient costs two for each parameter, drawn in one batch, and is the
alternative that the paper leaves for later.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from typing import Protocol

import numpy as np

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.objective import Batched
from abs_engine.core.params import ParamSpec
from abs_engine.optimise.base import Solution, unit_of
from abs_engine.optimise.history import CONVERGED, LIMIT, checked_start
from abs_engine.optimise.settings import SOLVING


class Pushed(Batched, Protocol):
    """One that also knows which way forces push the parameters."""

    def push(self, x: FloatArray) -> FloatArray:
        """Change of the parameters (N,) under the forces at `x`; its length is a first stride."""
        ...


@dataclass(frozen=True)
class Forces:
    """Follow the forces until they lead nowhere better.

    It ends where an iteration improves the value by less than `tolerance`, in the objective's
    units, or after `limit` iterations: directions that are asked for.
    """

    tolerance: float = SOLVING.ascent_tolerance
    limit: int = SOLVING.ascent_limit

    def minimise(self, objective: Pushed, start: FloatArray, spec: ParamSpec) -> Solution:
        """Minimise from `start` (N,), within the bounds of `spec`.

        A direction is shortened to `SOLVING.longest_way` in any parameter. `n_evaluations` counts
        values, and one drawing for each direction. Raises `ParameterError` if `start` is not finite
        or has another length than `spec`.
        """
        return _climb(self, objective, objective.push, start, spec, cost=1)


class Yielding(Pushed, Protocol):
    """One that also knows how far its parameters give way to the forces, before that is scaled."""

    def give_way(self, x: FloatArray) -> FloatArray:
        """Change of the parameters (N,) under unit forces at `x`."""
        ...


@dataclass(frozen=True)
class FixedStep:
    """Follow the forces by one constant, from one start, as Basu et al. print it (eqs. 12, 13).

    The constant alpha "scales the force to match the physics of the model", and is not printed:
    here it is such that the first push moves no node farther than `push` allows, and stays so.
    `tolerance` and `limit` are as of `Forces`.
    """

    tolerance: float = SOLVING.ascent_tolerance
    limit: int = SOLVING.ascent_limit

    def minimise(self, objective: Yielding, start: FloatArray, spec: ParamSpec) -> Solution:
        """Minimise from `start`; see `Forces.minimise`. The best place is what is returned."""
        x = checked_start(start, spec)
        pushed, free = objective.push(x), objective.give_way(x)
        alpha = np.divide(pushed, free, out=np.zeros_like(free), where=free != 0)
        best = objective(x)
        where, trace, spent, step = x, [best.value], 3, pushed
        status, iterations = LIMIT, 0
        while iterations < self.limit:
            iterations += 1
            x = spec.clip(x + step)
            found = objective(x)
            spent += 1
            trace.append(found.value)
            gain = best.value - found.value
            if gain > 0:
                best, where = found, x
            if gain < self.tolerance * unit_of(objective):
                status = CONVERGED
                break
            step = alpha * objective.give_way(x)
            spent += 1
        return Solution(where, status, best.value, best.terms, spent, np.array(trace), iterations)


@dataclass(frozen=True)
class Gradient:
    """Steepest descent in parameters measured by their scales, from central differences.

    `tolerance` and `limit` are as of `Forces`; `reach` is the difference step, in scales, shorter
    at a bound. A drawing changes by whole pixels, so it may not be small.
    """

    tolerance: float = SOLVING.ascent_tolerance
    limit: int = SOLVING.gradient_limit
    reach: float = SOLVING.gradient_difference

    def minimise(self, objective: Batched, start: FloatArray, spec: ParamSpec) -> Solution:
        """Minimise from `start`; see `Forces.minimise`. `n_evaluations` counts the differences."""

        def downhill(x: FloatArray) -> FloatArray:
            step = np.diag(self.reach * spec.scale)
            ends = np.stack([x + step, x - step])
            inside = spec.clip(ends)
            apart = np.diag(inside[0] - inside[1]) / spec.scale
            apart = np.where((inside == ends).all(axis=(0, 2)), 2 * self.reach, apart)
            values = objective.values(inside.reshape(-1, len(x)))
            slope = (values[: len(x)] - values[len(x) :]) / apart  # per scale
            steepest = np.linalg.norm(slope)
            return -spec.scale * slope / steepest if steepest > 0 else np.zeros_like(x)

        return _climb(self, objective, downhill, start, spec, cost=2 * len(spec))


def _climb(
    solver: Forces | Gradient,
    objective: Batched,
    direction: Callable[[FloatArray], FloatArray],
    start: FloatArray,
    spec: ParamSpec,
    cost: int,
) -> Solution:
    """Walk along `direction`, whose every call costs `cost` evaluations."""
    tolerance, limit = solver.tolerance * unit_of(objective), solver.limit
    x, parts = checked_start(start, spec), _parts(spec)
    value, moved, stride = objective(x).value, np.zeros_like(x), 1.0
    trace, spent, status, iterations = [value], 1, LIMIT, 0
    while iterations < limit:
        iterations += 1
        ways = parts * _bounded(direction(x), spec)
        spent += cost
        each = [SOLVING.strides if way.any() else (0.0,) for way in ways]
        multiples = np.array(list(product(*each)))  # (S, K): strides of the parts, each with each
        gain, stride = 0.0, max(stride, SOLVING.shortest)
        while gain <= 0 and stride >= SOLVING.shortest and ways.any():
            along = x + stride * multiples @ ways
            shares = SOLVING.memory if moved.any() else (0.0,)
            tried = spec.clip(np.vstack([along + share * moved for share in shares]))
            values = np.nan_to_num(objective.values(tried), nan=np.inf)
            spent += len(tried)
            trace += values.tolist()
            lowest = int(np.argmin(values))
            gain = value - float(values[lowest])
            stride *= (
                float(multiples[lowest % len(multiples)].max()) if gain > 0 else SOLVING.shorter
            )
        if gain > 0:
            x, moved, value = tried[lowest], tried[lowest] - x, float(values[lowest])
        if gain <= 0 or gain < tolerance:
            status = CONVERGED
            break
    last = objective(x)
    values = np.array([*trace, last.value])
    return Solution(x, status, last.value, last.terms, spent + 1, values, iterations)


def _parts(spec: ParamSpec) -> BoolArray:
    """Masks (K, N) of the parameters that share a stride: the pose's, and the shape's."""
    shape = np.array([unit == "sd" for unit in spec.units], bool)
    return np.array([part for part in (~shape, shape) if part.any()], bool).reshape(-1, len(spec))


def _bounded(way: FloatArray, spec: ParamSpec) -> FloatArray:
    """A direction, shortened so that no parameter moves farther than `SOLVING.longest_way`."""
    longest = float(np.abs(way / spec.scale).max(initial=0.0))
    most = SOLVING.longest_way
    return way if longest <= most else way * (most / longest)
