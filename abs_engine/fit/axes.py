"""The search of a frame of a sequence: Gauss-Newton steps, then a simplex along their axes.

Nelder-Mead alone, as in the paper, spends its evaluations on finding out which parameters pull
together; the Gauss-Newton matrix says so after one for each parameter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.objective import Evaluation
from abs_engine.core.params import ParamSpec
from abs_engine.fit.residuals import parts
from abs_engine.fit.talking import Problem
from abs_engine.optimise.simplex import Simplex

FloatArray = NDArray[np.float64]
_DIFFERENCE = 1.0
"""Step of the differences, in first steps of the parameters: half a standard deviation, a pixel.
Smaller ones see the texture's grain: with 0.1 searches end a third farther off."""
_DAMPING, _LEAST_DAMPING, _TRIES, _STIFFER = 1e-2, 1e-4, 3, 8.0
_LONGEST = 2.0
"""Largest edge of the second simplex, in first steps of the parameters."""
_EDGE = 0.01
"""By how much an edge raises epsilon, in what a wrong match costs."""


@dataclass(frozen=True, eq=False)
class Held:
    """Epsilon, and what it costs to leave the expected place.

    Parameters
    ----------
    problem : Problem
    centre : (n,) float64
        Where the parameters that are sought are expected.
    inertia : float
        What it costs to be off by a first step of a parameter, in what a wrong match costs; 0 is
        the paper's epsilon.
    """

    problem: Problem
    centre: FloatArray
    inertia: float

    @property
    def spec(self) -> ParamSpec:
        """Of the parameters that are sought."""
        return self.problem.spec

    @property
    def wrong(self) -> float:
        """What a wrong match costs."""
        return self.problem.wrong

    def values(self, vectors: FloatArray) -> FloatArray:
        """What is minimised, (B,), at parameter vectors (B, n)."""
        off = (vectors - self.centre) / self.spec.scale
        pull = self.inertia * self.wrong * (off**2).sum(axis=1)
        return np.asarray(self.problem.error.values(self._whole(vectors)) + pull)

    def _whole(self, vectors: FloatArray) -> FloatArray:
        """All 6 + P parameters of each vector."""
        return np.array([self.problem.whole(row) for row in vectors])

    def matrix(self, x: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """Value, Gauss-Newton matrix (n, n) and half the gradient (n,), per first step, at x."""
        steps = x + np.diag(_DIFFERENCE * self.spec.scale)
        error = self.problem.error
        here, beside = parts(error, self._whole(x[None])), parts(error, self._whole(steps))
        both = here.there & beside.there
        slopes = np.where(both, beside.rows - here.rows, 0) / _DIFFERENCE
        walls = (beside.penalty - here.penalty) / _DIFFERENCE
        pull = self.inertia * self.wrong
        off = (x - self.centre) / self.spec.scale
        slopes, here_rows = here.mixed(slopes), here.mixed(here.rows)[0]
        squared = np.asarray(slopes @ slopes.T, np.float64) + walls @ walls.T
        gradient = np.asarray(slopes @ here_rows, np.float64) + walls @ here.penalty[0]
        value = float(here.value[0] + pull * (off**2).sum())
        return value, squared + pull * np.eye(len(x)), gradient + pull * off


@dataclass(frozen=True, eq=False)
class Found:
    """Where a search ended.

    Parameters
    ----------
    x : (n,) float64
    value : float
    matrix : (n, n) float64
        Gauss-Newton's, at the last place where it was made.
    evaluations : int
    """

    x: FloatArray
    value: float
    matrix: FloatArray
    evaluations: int


def descend(held: Held, x: FloatArray, limit: int, tolerance: float, most: int = 4) -> Found:
    """Damped Gauss-Newton steps (Levenberg-Marquardt) with differences for slopes.

    Parameters
    ----------
    held : Held
    x : (n,) float64
    limit : int
        Largest number of evaluations.
    tolerance : float
        Stop when a step gains less, in what a wrong match costs.
    most : int
        Largest number of steps.
    """
    spec, damping, spent = held.spec, _DAMPING, 0
    value, matrix = np.inf, np.eye(len(x))
    for _ in range(most):
        if spent and spent + len(x) + 1 + _TRIES > limit:
            break
        value, matrix, gradient = held.matrix(x)
        spent += len(x) + 1
        for _try in range(_TRIES):
            stiff = matrix + damping * np.diag(np.diag(matrix) + 1e-12)
            y = spec.clip(x - np.linalg.solve(stiff, gradient) * spec.scale)
            new = float(held.values(y[None])[0])
            spent += 1
            if new < value:
                break
            damping = _STIFFER * max(damping, 1e-3)
        if not new < value:
            break
        gain, x, value = value - new, y, new
        damping = max(damping / _STIFFER, _LEAST_DAMPING)
        if gain < tolerance * held.wrong:
            break
    return Found(x, value, matrix, spent)


def polish(held: Held, found: Found, limit: int, tolerance: float) -> Found:
    """Nelder-Mead along the axes of a Gauss-Newton matrix, from where a descent ended.

    Parameters
    ----------
    held : Held
    found : Found
    limit : int
        Largest number of evaluations; none are made where it is not positive.
    tolerance : float
        Stop when the simplex's values differ by less, in what a wrong match costs.
    """
    size = len(found.x)
    if limit <= size:
        return found
    curve, axes = np.linalg.eigh(found.matrix)
    length = np.sqrt(_EDGE * held.wrong / np.maximum(curve, 1e-12 * curve.max()))
    turned = axes * np.minimum(length, _LONGEST) * held.spec.scale[:, None]

    def place(y: FloatArray) -> FloatArray:
        return held.spec.clip(found.x + turned @ y)

    def objective(x: FloatArray) -> Evaluation:
        return Evaluation(float(held.values(place(x)[None])[0]), {})

    names = tuple(f"axis{k}" for k in range(size))
    far = np.full(size, 1e3)
    plain = ParamSpec(names, ("",) * size, np.ones(size), -far, far)
    best = Simplex(tolerance * held.wrong, limit).minimise(objective, np.zeros(size), plain)
    spent = found.evaluations + best.n_evaluations
    if best.value >= found.value:
        return Found(found.x, found.value, found.matrix, spent)
    return Found(place(best.x), best.value, found.matrix, spent)
