"""Named parameters as immutable values; a flat vector only inside a solver."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import ParameterError


@dataclass(frozen=True, eq=False)
class ParamSpec:
    """Meaning of the numbers of a parameter vector.

    Parameters
    ----------
    names : tuple of str
    units : tuple of str
        "mm", "rad", or "sd" (standard deviations of a mode).
    scale : (N,) float64
        A typical step of each parameter; solvers start from it.
    lower, upper : (N,) float64
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    scale: NDArray[np.float64]
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]

    def __post_init__(self) -> None:
        sizes = {
            len(self.names),
            len(self.units),
            len(self.scale),
            len(self.lower),
            len(self.upper),
        }
        if len(sizes) != 1:
            raise ParameterError(
                "names, units, scale and bounds differ in length", "check the spec"
            )
        if not (np.all(self.scale > 0) and np.all(self.lower < self.upper)):
            raise ParameterError("a scale is not positive or a bound is empty", "check the spec")

    def __len__(self) -> int:
        return len(self.names)

    def only(self, which: NDArray[np.integer]) -> ParamSpec:
        """The spec of some of the parameters, by their indices (M,)."""
        return ParamSpec(
            tuple(self.names[i] for i in which), tuple(self.units[i] for i in which),
            self.scale[which], self.lower[which], self.upper[which],
        )  # fmt: skip

    def clip(self, vector: NDArray[np.float64]) -> NDArray[np.float64]:
        """The nearest vector inside of the bounds."""
        return np.asarray(np.clip(vector, self.lower, self.upper))
