"""The search of one frame: from the best of some starts, once more where that came to little."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.params import ParamSpec
from abs_engine.fit.problem import Problem
from abs_engine.optimise.base import Solution

FloatArray = NDArray[np.float64]


class Minimiser(Protocol):
    """What moves the parameters until the value is least; it sees numbers and nothing else."""

    def minimise(self, objective: Any, start: FloatArray, spec: ParamSpec) -> Solution:
        """Minimise from `start` (N,)."""
        ...


@runtime_checkable
class Phased(Protocol):
    """A minimiser that descends first and polishes what it came to."""

    @property
    def limit(self) -> int:
        """Largest number of evaluations."""
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
    """Where a search starts again, if what it came to is worse than usual.

    Parameters
    ----------
    postures : (K, P) float64
    worse : callable
        Whether a value is worse than usual.
    """

    postures: FloatArray
    worse: Callable[[float], bool]


def several(problem: Problem, starts: FloatArray, driver: Minimiser, keep: int) -> list[Solution]:
    """Minimise from each of the best of some starts (K, N), which are compared in one batch."""
    order = np.argsort(problem.values(starts))[:keep]
    return [driver.minimise(problem, starts[k], problem.spec) for k in order]


def search(
    problem: Problem,
    starts: FloatArray,
    driver: Minimiser,
    again: Again | None = None,
    charged: bool = False,
) -> tuple[Solution, bool]:
    """Minimise from the best of some starts.

    Parameters
    ----------
    problem : Problem
    starts : (K, N) float64
        Over the free parameters; of several the best is chosen, drawn in one batch.
    driver : Minimiser
    again : Again, optional
        For drivers of two phases, between them.
    charged : bool
        Whether a limit on evaluations counts those of the starts, too.

    Returns
    -------
    Solution
        `n_evaluations` counts those of the starts.
    bool
        Whether it started again.
    """
    start, spent, spec = starts[0], 0, problem.spec
    if len(starts) > 1:
        start, spent = starts[int(np.argmin(problem.values(starts)))], len(starts)
    if not isinstance(driver, Phased):
        own = _with_limit(driver, spent) if charged else driver
        found = own.minimise(problem, start, spec)
        return replace(found, n_evaluations=found.n_evaluations + spent), False
    used = spent if charged else 0
    found = driver.descend(problem, start, spec, driver.limit - used)
    used += found.n_evaluations
    restarted = False
    if again is not None and again.worse(found.value):
        room = driver.limit - used - len(again.postures)
        restarted = room > len(start)
        if restarted:
            rows = np.tile(found.x, (len(again.postures), 1))
            rows[:, -again.postures.shape[1] :] = again.postures
            first = rows[int(np.argmin(problem.values(rows)))]
            other = driver.descend(problem, first, spec, room, free=True)
            used += len(again.postures) + other.n_evaluations
            found = other if other.value < found.value else found
    counted = replace(found, n_evaluations=used)
    done = driver.polish(problem, counted, spec, start, driver.limit - used)
    extra = 0 if charged else spent
    return replace(done, n_evaluations=done.n_evaluations + extra), restarted


def _with_limit(driver: Any, spent: int) -> Any:
    """The driver with what is left of its evaluations."""
    return replace(driver, limit=driver.limit - spent) if hasattr(driver, "limit") else driver
