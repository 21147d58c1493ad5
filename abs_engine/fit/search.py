"""The search of one frame: from the best of some starts, once more where that came to little."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol, runtime_checkable

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.blocks import POSTURE
from abs_engine.core.params import ParamSpec
from abs_engine.fit.answers import answer, polished
from abs_engine.fit.problem import Problem
from abs_engine.optimise.base import Solution


class Minimiser(Protocol):
    """Solver that moves parameters until the value is least; it sees nothing but numbers."""

    def minimise(self, objective: Any, start: FloatArray, spec: ParamSpec) -> Solution:
        """Minimise from `start` (N,)."""
        ...


@runtime_checkable
class Phased(Minimiser, Protocol):
    """A minimiser that descends first and polishes what it came to."""

    @property
    def limit(self) -> int:
        """Largest number of evaluations."""
        ...

    @property
    def starts(self) -> int:
        """Of several starts, how many of the best are descended from."""
        ...

    def descend(
        self, objective: Any, start: FloatArray, spec: ParamSpec, limit: int, *, free: bool = False
    ) -> Solution:
        """Descend from `start` (N,)."""
        ...

    def polish(
        self, objective: Any, found: Solution, spec: ParamSpec, centre: FloatArray, limit: int
    ) -> Solution:
        """Improve on what was found after a start at `centre` (N,)."""
        ...


@dataclass(frozen=True, eq=False)
class Again:
    """Starts (K, P) of a repeated search, if what it came to is `worse` than usual."""

    postures: FloatArray
    worse: Callable[[float], bool]


@dataclass(frozen=True, eq=False)
class Found:
    """Result of a search.

    Parameters
    ----------
    x : (N,) float64
        Free parameters: those of `best`, or a mean of several ends.
    best : Solution
        The least value. Evaluations include those of all starts and ends.
    again : bool
        Whether it started again.
    """

    x: FloatArray
    best: Solution
    again: bool = False


def mean_of(ends: Sequence[Solution]) -> FloatArray:
    """The mean (N,) of several ends by the probability that each has.

    Where the picture leaves several shapes about as probable, no choice of one of them is off less
    on the average than their mean. Only the height of each maximum counts, not how wide it is.
    """
    lowest = min(end.value for end in ends)
    weight = np.exp([lowest - end.value for end in ends])
    return np.asarray(weight @ np.stack([end.x for end in ends]) / weight.sum())


def averaged(problem: Problem, starts: FloatArray, driver: Minimiser, tried: int) -> Found:
    """Minimise from each of the best of some starts (K, N); what is found is their mean."""
    ends = several(problem, starts, driver, tried)
    spent = len(starts) + sum(end.n_evaluations for end in ends)
    best = min(ends, key=lambda end: end.value)
    return Found(mean_of(ends), replace(best, n_evaluations=spent))


def several(problem: Problem, starts: FloatArray, driver: Minimiser, keep: int) -> list[Solution]:
    """Minimise from each of the best of some starts (K, N), which are compared in one batch."""
    order = np.argsort(problem.values(starts))[:keep]
    step, spec = driver.minimise, problem.spec
    return [answer(driver, step, problem, starts[k], spec) for k in order]


def search(
    problem: Problem,
    starts: FloatArray,
    driver: Minimiser,
    again: Again | None = None,
    charged: bool = False,
) -> Found:
    """Minimise from the best of some starts (K, N) over the free parameters, drawn in one batch.

    Drivers of two phases begin `again` between them. If `charged`, a limit on evaluations counts
    those of the starts, too. Errors are those of `answer`.
    """
    spent, spec = 0, problem.spec
    if len(starts) > 1:
        starts, spent = starts[np.argsort(problem.values(starts), kind="stable")], len(starts)
    start = starts[0]
    if not isinstance(driver, Phased):
        own = _with_limit(driver, spent) if charged else driver
        found = answer(own, own.minimise, problem, start, spec)
        return Found(found.x, replace(found, n_evaluations=found.n_evaluations + spent))
    used = spent if charged else 0
    descend = driver.descend
    found = answer(driver, descend, problem, start, spec, driver.limit - used)
    used += found.n_evaluations
    for beside in starts[1 : driver.starts]:
        other = answer(driver, descend, problem, beside, spec, driver.limit - used)
        used += other.n_evaluations
        found = other if other.value < found.value else found
    restarted = False
    if again is not None and again.worse(found.value):
        room = driver.limit - used - len(again.postures)
        restarted = room > len(start)
        if restarted:
            first = _again_from(problem, found.x, again.postures)
            other = answer(driver, descend, problem, first, spec, room, free=True)
            used += len(again.postures) + other.n_evaluations
            if other.value < found.value:
                found, start = other, other.x  # nothing pulls back to where the first one began
    counted = replace(found, n_evaluations=used)
    room = driver.limit - used
    done = polished(driver, driver.polish, problem, counted, spec, start, room)
    extra = 0 if charged else spent
    return Found(done.x, replace(done, n_evaluations=done.n_evaluations + extra), restarted)


def _again_from(problem: Problem, x: FloatArray, postures: FloatArray) -> FloatArray:
    """The best of some postures (K, P) where all else is as it was found, over what is free."""
    whole = np.tile(problem.whole(x), (len(postures), 1))
    whole[:, problem.blocks.places[POSTURE]] = postures
    rows = problem.chosen(whole)
    return np.asarray(rows[int(np.argmin(problem.values(rows)))])


def _with_limit(driver: Any, spent: int) -> Any:
    """The driver with what is left of its evaluations."""
    return replace(driver, limit=driver.limit - spent) if hasattr(driver, "limit") else driver
