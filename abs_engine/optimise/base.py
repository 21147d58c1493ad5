"""What every solver returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Solution:
    """Where a solver ended, and how.

    Parameters
    ----------
    x : (N,) float64
        The best parameters seen.
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
    """

    x: NDArray[np.float64]
    status: str
    value: float
    terms: Mapping[str, float]
    n_evaluations: int
    trace: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    n_iterations: int = 0
