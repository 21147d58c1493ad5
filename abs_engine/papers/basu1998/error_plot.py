"""The error of the lips frame by frame, a line for each driver."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from abs_engine.core.arrays import FloatArray
from abs_engine.report.drawing.colours import system_colour
from abs_engine.report.drawing.figure import plain

_LEAST_MM = 0.1  # the axis goes that far


def error_plot(
    series: Mapping[str, Sequence[float]],
    goal: float | None = None,
    breaks: Mapping[int, str] | None = None,
) -> Figure:
    """Errors over the frames.

    Parameters
    ----------
    series : mapping of str to sequence of float, mm
        By what made them; what is not finite is a gap.
    goal : float, mm, optional
        Drawn as a dashed line.
    breaks : mapping of int to str, optional
        Where in the frames another view begins, and its name.
    """
    figure = Figure(figsize=(9, 3.2), layout="constrained")
    axes = figure.subplots()
    high = max(_LEAST_MM, 1.2 * (goal or 0.0))
    for number, (name, given) in enumerate(series.items()):
        errors = np.asarray(given, np.float64)
        known = errors[np.isfinite(errors)]
        high = max(high, 1.1 * float(known.max(initial=0.0)))
        axes.plot(
            errors, ".-", color=system_colour(number), lw=1.2, ms=4, label=_label(name, known)
        )
    if goal is not None:
        axes.axhline(goal, color="0.4", lw=1, ls="--", label=f"goal: {goal:g} mm")
    _mark_views(axes, breaks or {}, high)
    axes.set(xlabel="frame", ylabel="lip error (mm)", ylim=(0, high))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.grid(axis="y", color="0.88")
    if axes.lines:
        figure.legend(loc="outside upper left", ncols=len(axes.lines), fontsize=8, frameon=False)
    return figure


def _label(name: str, known: FloatArray) -> str:
    """Name of a line, with the root mean square of its errors."""
    rms = f"{math.sqrt((known**2).mean()):.2f} mm RMS" if len(known) else "not measured"
    return plain(f"{name}, {rms}")


def _mark_views(axes: Axes, breaks: Mapping[int, str], high: float) -> None:
    for frame, name in breaks.items():
        axes.axvline(frame - 0.5, color="0.75", lw=0.8)
        axes.text(frame - 0.3, 0.98 * high, name, va="top", color="0.4", fontsize=8)
