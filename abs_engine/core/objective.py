"""The value that a solver minimises."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

from abs_engine.core.arrays import FloatArray


@dataclass(frozen=True)
class Evaluation:
    """One value of an objective and what it is made of.

    Parameters
    ----------
    value : float
        What is minimised.
    terms : mapping of str to float
        The parts that `value` is the sum of.
    """

    value: float
    terms: Mapping[str, float] = field(default_factory=dict)


class Objective(Protocol):
    """A function of a flat parameter vector (N,) float64."""

    def __call__(self, x: FloatArray) -> Evaluation:
        """Evaluate at `x`; a pure function of `x`."""
        ...


class Batched(Objective, Protocol):
    """An objective that is evaluated at many vectors at once."""

    def values(self, vectors: FloatArray) -> FloatArray:
        """Values (B,) at vectors (B, N)."""
        ...
