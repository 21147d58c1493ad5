"""The collection of a reproduction: numbers, remarks, and the figures of the fits."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from abs_engine.core.arrays import FloatArray
from abs_engine.dataset.view import Truth
from abs_engine.io.files import png
from abs_engine.papers.basu1998.experiment import FrameError, TrainedLips
from abs_engine.papers.basu1998.filmed import FRONT, YAWS, Amount, camera_name
from abs_engine.papers.basu1998.page_by_yaw import degrees
from abs_engine.papers.basu1998.pictures import (
    ShownFit,
    convergence_figure,
    fits_figure,
    probability_figure,
)
from abs_engine.papers.results import Reproduction
from abs_engine.report.drawing.colours import system_colour
from abs_engine.report.drawing.figure import figure_bytes, plain

BEST = "simplex"
"""The driver whose errors are held against the goals."""
_GOAL = 1.0  # mm


@dataclass
class Report(Reproduction):
    """A reproduction under way, of so much film."""

    amount: Amount
    remarks: list[str] = field(default_factory=list)


def fit_figures(
    report: Report,
    lips: TrainedLips,
    sides: Mapping[str, Truth],
    known: Sequence[FrameError],
) -> None:
    """Keep figures 3 to 9 of one person.

    `sides` is the test clip by camera; `known` are fits with the pose known, of this person and
    by `BEST` among them.
    """
    front, renderer = sides[FRONT], report.renderer
    opened = int(np.argmax(front.aperture))
    picture = list(front.pictures())[opened]
    pose, camera = front.pose(opened), front.camera
    report.figure(
        "figure3.png", png(probability_figure(lips, picture, pose, camera, renderer)),
        "Figures 3 and 4: probability maps of lips and skin, raw and smoothed; teeth and dark.",
    )  # fmt: skip
    truth = lips.model.shell.nodes(front.vertices(opened))
    report.figure(
        "figure5.png", png(convergence_figure(lips, picture, pose, camera, renderer, truth)),
        "Figure 5: from the initial image to the final fit.",
    )  # fmt: skip
    shown = []
    for yaw in (YAWS[0], 0, YAWS[-1]):
        view = sides[camera_name(yaw)]
        fit = next(
            e.fit for e in known
            if (e.camera, e.frame, e.driver) == (camera_name(yaw), opened, BEST)
        )  # fmt: skip
        image = list(view.pictures())[opened]
        shown.append(ShownFit(f"seen from {yaw} degrees", image, view.camera, fit.pose, fit.nodes))
    report.figure(
        "figure6.png", png(fits_figure(renderer, lips, shown)),
        "Figures 6 to 9: initial image, final fit, and the shape in 3D.",
    )  # fmt: skip
    plot = error_plot(*by_driver(known, lips.person))
    caption = f"Error of {lips.person}'s lips in each frame, by driver and by side."
    report.figure("errors.svg", figure_bytes(plot, "svg"), caption)


def by_driver(
    known: Sequence[FrameError], person: str
) -> tuple[dict[str, list[float]], dict[int, str]]:
    """A person's errors and where each side begins, as `error_plot` takes them."""
    sides = {camera_name(yaw): degrees(yaw) for yaw in YAWS}
    curves: dict[str, list[float]] = {}
    breaks: dict[int, str] = {}
    for name in ("forces", "gradient", "simplex"):
        mine = [e for e in known if e.driver == name and e.person == person]
        breaks = {i: sides[e.camera] for i, e in enumerate(mine) if e.frame == 0}
        curves[name] = [e.rms for e in mine]
    return curves, breaks


def error_plot(series: Mapping[str, Sequence[float]], breaks: Mapping[int, str]) -> Figure:
    """Errors over the frames, and the goal as a dashed line.

    Parameters
    ----------
    series : mapping of str to sequence of float, mm
        By what made them; what is not finite is a gap.
    breaks : mapping of int to str
        Where in the frames another view begins, and its name.
    """
    figure = Figure(figsize=(9, 3.2), layout="constrained")
    axes = figure.subplots()
    high = 1.2 * _GOAL
    for number, (name, given) in enumerate(series.items()):
        errors = np.asarray(given, np.float64)
        known = errors[np.isfinite(errors)]
        high = max(high, 1.1 * float(known.max(initial=0.0)))
        axes.plot(
            errors, ".-", color=system_colour(number), lw=1.2, ms=4, label=_label(name, known)
        )
    axes.axhline(_GOAL, color="0.4", lw=1, ls="--", label=f"goal: {_GOAL:g} mm")
    for frame, name in breaks.items():
        axes.axvline(frame - 0.5, color="0.75", lw=0.8)
        axes.text(frame - 0.3, 0.98 * high, name, va="top", color="0.4", fontsize=8)
    axes.set(xlabel="frame", ylabel="lip error (mm)", ylim=(0, high))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.grid(axis="y", color="0.88")
    figure.legend(loc="outside upper left", ncols=len(axes.lines), fontsize=8, frameon=False)
    return figure


def _label(name: str, known: FloatArray) -> str:
    """Name of a line, with the root mean square of its errors."""
    rms = f"{math.sqrt((known**2).mean()):.2f} mm RMS" if len(known) else "not measured"
    return plain(f"{name}, {rms}")
