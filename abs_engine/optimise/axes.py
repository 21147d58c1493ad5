"""Gauss-Newton steps, then a simplex along their axes.

Nelder-Mead alone spends its evaluations on finding out which parameters pull together; the
Gauss-Newton matrix says so after one for each parameter.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.objective import Evaluation
from abs_engine.core.params import ParamSpec
from abs_engine.optimise.anchored import Held, Quadratic, check_quadratic
from abs_engine.optimise.base import Solution
from abs_engine.optimise.by_nlopt import Simplex
from abs_engine.optimise.history import checked_start
from abs_engine.optimise.levenberg import LevenbergMarquardt
from abs_engine.optimise.settings import SOLVING

_FEWEST = 2  # axes of a simplex


@dataclass(frozen=True)
class AxesSimplex:
    """Minimise by a few damped Gauss-Newton steps and Nelder-Mead along the axes of their matrix.

    Differences are those of a first step: half a standard deviation, a pixel. Smaller ones see the
    texture's grain: with 0.1 searches end a third farther off.

    Parameters
    ----------
    limit : int
        Largest number of evaluations.
    coarse, tolerance : float
        Where the descent, and where the simplex, stops; in the objective's units.
    inertia : float
        See `anchored.Held`; of the results it is in the trace, not in the value.
    starts : int
        Of several starts, how many of the best are descended from.
    """

    limit: int = SOLVING.axes_limit
    coarse: float = SOLVING.squares_tolerance
    tolerance: float = SOLVING.squares_tolerance
    inertia: float = 0.0
    starts: int = 1

    def minimise(
        self, objective: Quadratic, start: FloatArray, spec: ParamSpec, _step: float = 1.0
    ) -> Solution:
        """Minimise from `start`; parameters and errors as `by_nlopt.Simplex.minimise`.

        Raises `ParameterError` also if the objective has no residuals.
        """
        first = checked_start(start, spec)
        found = self.descend(objective, first, spec, self.limit)
        return self.polish(objective, found, spec, first, self.limit - found.n_evaluations)

    def descend(
        self,
        objective: Quadratic,
        start: FloatArray,
        spec: ParamSpec,
        limit: int,
        *,
        free: bool = False,
    ) -> Solution:
        """The Gauss-Newton steps from `start` (n,) within so many evaluations.

        With `free` nothing pulls towards the start.
        """
        check_quadratic(objective)
        descent = LevenbergMarquardt(
            self.coarse, limit, SOLVING.axes_difference, SOLVING.axes_steps, SOLVING.axes_tries
        )
        held = Held(objective, spec, start, 0.0 if free else self.inertia)
        return descent.descend(held, start, limit)

    def polish(
        self, objective: Quadratic, found: Solution, spec: ParamSpec, centre: FloatArray, limit: int
    ) -> Solution:
        """Nelder-Mead along the axes of a Gauss-Newton matrix, from where a descent ended.

        The parameters are pulled towards `centre` (n,). There are so many evaluations at most,
        `limit`; none are made where it is too small for a simplex.
        """
        held = Held(objective, spec, centre, self.inertia)
        edge, tolerance = SOLVING.axes_edge * held.unit, self.tolerance * held.unit
        pulled = replace(found, value=found.value + float(held.pull(found.x)))
        best = along_axes(held.values, pulled, spec, tolerance, limit, edge)
        return replace(best, value=best.value - float(held.pull(best.x)))


def along_axes(
    values: Callable[[FloatArray], FloatArray],
    found: Solution,
    spec: ParamSpec,
    tolerance: float,
    limit: int,
    edge: float,
) -> Solution:
    """Nelder-Mead along the axes of a descent's last matrix, from where it ended.

    Of few evaluations the first simplex takes half: then only the least certain axes have an edge.

    Parameters
    ----------
    values : callable
        Values (B,) at vectors (B, n).
    found : Solution
        With its information.
    tolerance : float, of the objective
        Differences of values below which the search ends.
    limit : int
        Largest number of evaluations; none are made where it is too small for a triangle.
    edge : float
        By how much an edge of the first simplex raises the value.
    """
    size = min(len(found.x), limit // 2)
    if size < _FEWEST or found.information is None:
        return found
    curve, axes = np.linalg.eigh(found.information)
    length = np.sqrt(edge / np.maximum(curve, 1e-12 * curve.max()))
    turned = (axes * np.minimum(length, SOLVING.longest_edge) * spec.scale[:, None])[:, :size]

    def place(y: FloatArray) -> FloatArray:
        return spec.clip(found.x + turned @ y)

    def along(x: FloatArray) -> Evaluation:
        return Evaluation(float(values(place(x)[None])[0]), {})

    names = tuple(f"axis{k}" for k in range(size))
    far = np.full(size, 1e3)
    plain = ParamSpec(names, ("",) * size, np.ones(size), -far, far)
    best = Simplex(tolerance, limit).minimise(along, np.zeros(size), plain)
    spent = found.n_evaluations + best.n_evaluations
    trace = np.r_[found.trace, best.trace]
    if best.value >= found.value:
        return replace(found, status=best.status, n_evaluations=spent, trace=trace)
    better = place(best.x), best.value, best.status
    return replace(
        found, x=better[0], value=better[1], status=better[2], n_evaluations=spent, trace=trace
    )
