"""The drivers that can be chosen by name, with what they stop at beside a frame in nats."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

from abs_engine.core.errors import PluginError
from abs_engine.core.foreign import blamed, own
from abs_engine.optimise.ascent import FixedStep, Forces, Gradient
from abs_engine.optimise.axes import AxesSimplex
from abs_engine.optimise.by_nlopt import DerivativeFree, Simplex
from abs_engine.optimise.levenberg import LevenbergMarquardt
from abs_engine.optimise.newton import Newton
from abs_engine.optimise.restarted import RestartedSimplex
from abs_engine.optimise.settings import SOLVING
from abs_engine.optimise.variations import LocalVariations

Need = Literal["values", "forces", "residuals", "borders"]


@dataclass(frozen=True)
class Driver:
    """A driver that can be chosen.

    Parameters
    ----------
    make : callable
        Makes the minimiser of a frame: see `fit.search.Minimiser`.
    needs : {"values", "forces", "residuals", "borders"}
        What the evidence must give: values alone, forces on the drawn surface, or residuals.
    settings : dict
        What `make` was given, for the record of a run.

    Raises
    ------
    PluginError
        If `make` cannot be called.
    """

    make: Callable[..., Any]
    needs: Need = "values"
    settings: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse what cannot be called."""
        if not callable(self.make):
            raise PluginError(
                f"a Driver is made of {self.make!r}", "give it the class of a minimiser"
            )

    def minimiser(self, **other: Any) -> Any:
        """The minimiser, with other settings where they are given.

        Raises
        ------
        PluginError
            If `make` is a plugin's and fails, or makes nothing that can minimise.
        """
        given = {**self.settings, **other}
        if own(self.make):
            return self.make(**given)
        name = f"the driver '{getattr(self.make, '__name__', self.make)}'"
        with blamed(name):
            made = self.make(**given)
        if not callable(getattr(made, "minimise", None)):
            raise PluginError(
                f"{name} makes an object of type {type(made).__name__} without 'minimise'", "add it"
            )
        return made


_USUAL = {"tolerance": SOLVING.tolerance, "limit": SOLVING.limit}
SIMPLEX = Driver(Simplex, settings=_USUAL)
RESTARTED = Driver(RestartedSimplex, settings=_USUAL)
AXES = Driver(
    AxesSimplex,
    "residuals",
    {
        "limit": SOLVING.axes_limit,
        "coarse": SOLVING.tolerance,
        "tolerance": SOLVING.tolerance,
        "starts": SOLVING.axes_starts,
    },
)
LEVENBERG = Driver(
    LevenbergMarquardt, "residuals", {**_USUAL, "difference": SOLVING.axes_difference}
)
NEWTON = Driver(Newton, "borders", {"tolerance": SOLVING.tolerance})
NEWTON_QUICK = Driver(
    Newton, "borders", {**NEWTON.settings, "polished": 0, "reaches": SOLVING.quick_reaches}
)
"""Half the evaluations and no simplex: for a frame that is gone when the next one is there."""
FORCES = Driver(Forces, "forces")
FIXED_STEP = Driver(FixedStep, "forces")
GRADIENT = Driver(Gradient)
VARIATIONS = Driver(LocalVariations, settings=_USUAL)
SBPLX, BOBYQA, COBYLA, PRAXIS = (
    Driver(DerivativeFree, settings={"method": method, **_USUAL})
    for method in ("sbplx", "bobyqa", "cobyla", "praxis")
)
