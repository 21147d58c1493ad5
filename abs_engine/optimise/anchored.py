"""An objective, and what it costs to leave the place where its parameters are expected."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.objective import Batched
from abs_engine.core.params import ParamSpec
from abs_engine.optimise.base import unit_of


class Quadratic(Batched, Protocol):
    """An objective that knows its Gauss-Newton matrix."""

    def gauss_newton(
        self, x: FloatArray, scale: FloatArray, difference: float
    ) -> tuple[float, FloatArray, FloatArray]:
        """Value, matrix (n, n) and half the gradient (n,) at `x`, per `scale` (n,).

        Slopes are differences over `difference` scales; n + 1 evaluations.
        """
        ...


def check_quadratic(objective: object) -> None:
    """Raise `ParameterError` unless an objective has a Gauss-Newton matrix."""
    if not hasattr(objective, "gauss_newton"):
        raise ParameterError("the objective has no residuals", "choose another solver")


@dataclass(frozen=True, eq=False)
class Held:
    """An objective with a pull towards the place `centre` (n,) where the parameters are expected.

    `inertia` is what it costs to be off by a first step of a parameter, in the objective's units; 0
    is the objective itself.
    """

    objective: Quadratic
    spec: ParamSpec
    centre: FloatArray
    inertia: float = 0.0

    @property
    def unit(self) -> float:
        """The scale of tolerances, in units of the value."""
        return unit_of(self.objective)

    def values(self, vectors: FloatArray) -> FloatArray:
        """Objective, (B,), at parameter vectors (B, n)."""
        return np.asarray(self.objective.values(vectors) + self.pull(vectors))

    def pull(self, vectors: FloatArray) -> FloatArray:
        """The part (...) of the values at vectors (..., n) that is for being off the centre."""
        off = (vectors - self.centre) / self.spec.scale
        return np.asarray(self.inertia * self.unit * (off**2).sum(axis=-1))

    def gauss_newton(
        self, x: FloatArray, difference: float
    ) -> tuple[float, FloatArray, FloatArray]:
        """Value, Gauss-Newton matrix (n, n) and half the gradient (n,), per first step, at `x`."""
        scale = self.spec.scale
        sign = np.where(x + difference * scale <= self.spec.upper, 1.0, -1.0)  # keeps the bounds
        value, matrix, gradient = self.objective.gauss_newton(x, sign * scale, difference)
        matrix, gradient = matrix * np.outer(sign, sign), gradient * sign
        stiffness = self.inertia * self.unit
        return (
            float(value + self.pull(x)),
            matrix + stiffness * np.eye(len(x)),
            gradient + stiffness * (x - self.centre) / self.spec.scale,
        )
