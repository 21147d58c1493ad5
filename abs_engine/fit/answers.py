"""Answers of a plugin's driver, checked where they come back; the engine's own are trusted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import PluginError
from abs_engine.core.foreign import blamed, own
from abs_engine.optimise.base import Solution, unit_of

_OFF = 1e-3  # share of a value by which drivers may round it


def answer(
    driver: object,
    step: Callable[..., Solution],
    objective: Any,
    start: FloatArray,
    *more: Any,
    **named: Any,
) -> Solution:
    """End of a driver's step, one of its methods, from `start` (N,).

    Raises `PluginError` if the driver of a plugin fails, or returns anything but a solution.
    """
    if own(type(driver)):
        return step(objective, start, *more, **named)
    name = f"the driver '{type(driver).__name__}'"
    size = len(start)
    with blamed(name):
        found = step(objective, start, *more, **named)
    return _checked(name, found, size)


def polished(
    driver: object, step: Callable[..., Solution], objective: Any, found: Solution, *more: Any
) -> Solution:
    """End of a driver's step from what it found; errors as `answer`."""

    def improve(problem: Any, _start: FloatArray) -> Solution:
        return step(problem, found, *more)

    return answer(driver, improve, objective, found.x)


def _checked(name: str, found: object, size: int) -> Solution:
    """The solution, with arrays for what can be made one."""
    if not isinstance(found, Solution):
        raise PluginError(
            f"{name} returns an object of type {type(found).__name__}",
            "return a Solution: x, status, value, terms and n_evaluations",
        )
    if not _are_numbers(found.x, (size,)):
        raise PluginError(
            f"{name} returns an x that is not {size} finite numbers",
            "return one for each parameter of the start",
        )
    if not isinstance(found.status, str):
        raise PluginError(f"{name} returns the status {found.status!r}", "say why it stopped")
    if not _are_numbers(found.value, ()) or not _are_numbers(found.n_evaluations, ()):
        raise PluginError(
            f"{name} returns a value or a count of evaluations that is not a finite number",
            "return the objective's value at x, and how often it was asked for",
        )
    x = np.asarray(found.x, np.float64)
    return replace(found, x=x, value=float(found.value), n_evaluations=int(found.n_evaluations))


def _are_numbers(given: object, shape: tuple[int, ...]) -> bool:
    """Whether something is finite real numbers of a shape."""
    try:
        values = np.asarray(given)
    except ValueError:  # lists of several lengths
        return False
    return values.shape == shape and values.dtype.kind in "fiu" and bool(np.isfinite(values).all())


def check_value(driver: object, objective: Any, said: float, value: float) -> None:
    """Raise `PluginError` where a plugin's driver returns another value than the objective's."""
    if own(type(driver)) or abs(said - value) <= max(unit_of(objective), _OFF * abs(value)):
        return
    raise PluginError(
        f"the driver '{type(driver).__name__}' returns the value {said:g} for an x whose value is "
        f"{value:g}",
        "return the objective's value at x",
    )
