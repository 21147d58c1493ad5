"""The result that every solver returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Solution:
    """End of a solver, and the reason of its stop.

    Parameters
    ----------
    x : (N,) float64
        The best parameters that the search went to. Of places looked at for slopes alone, one may
        have been better.
    status : str
        "converged", "evaluation limit" or "failed: ...".
    value : float
        Objective at `x`.
    terms : mapping of str to float
        The parts of `value`.
    n_evaluations : int
    trace : (T,) float64
        Every value in the order of evaluation; no more than `n_evaluations`, which count the
        drawings that give a direction and no value, too.
    n_iterations : int
        Directions that were asked for, by solvers that do; else 0.
    information : (N, N) float64 or None
        Gauss-Newton's matrix at the last place where it was made, per scale of the parameters, by
        solvers that make one: half the value's second derivative.
    """

    x: NDArray[np.float64]
    status: str
    value: float
    terms: Mapping[str, float]
    n_evaluations: int
    trace: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    n_iterations: int = 0
    information: NDArray[np.float64] | None = None


def unit_of(objective: Any) -> float:
    """The scale of tolerances, in units of an objective's values: 1 where it has none."""
    return float(getattr(objective, "unit", 1.0))
