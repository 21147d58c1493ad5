"""The results of a reproduction beside the paper's numbers and the goals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from abs_engine.learn.reconstruction import TABLE_1
from abs_engine.papers.results import MISSING, Results, number

Unit = Literal["share", "error", "mm", "count"]
_FORMATS: dict[Unit, Callable[[float], str]] = {
    "share": lambda v: f"{v:.2%}",
    "error": lambda v: f"{v:.2e}",
    "mm": lambda v: f"{v:.2f} mm",
    "count": lambda v: f"{v:.0f}" if v >= 100 or v == int(v) else f"{v:.1f}",
}


@dataclass(frozen=True)
class Goal:
    """A number that was aimed at.

    Parameters
    ----------
    key : str
        Of the results, with dots.
    unit : {"share", "error", "mm", "count"}
    bound : float or None
        None where nothing was aimed at.
    least : bool
        The number is to be at least the bound, not at most.
    paper : bool
        The bound is the paper's own number.
    """

    key: str
    name: str
    unit: Unit
    bound: float | None
    least: bool = False
    paper: bool = False

    def told(self, results: Results) -> str:
        """Measured value, with its unit."""
        return told(number(results, self.key), self.unit)

    def aim(self) -> str:
        """Aim of the measurement."""
        if self.bound is None:
            return "none"
        sign, source = "≥" if self.least else "≤", " (paper)" if self.paper else ""
        return f"{sign} {told(self.bound, self.unit)}{source}"

    def verdict(self, results: Results) -> str:
        """Verdict, by how much it was met or missed; empty if it was not measured."""
        return self.judged(number(results, self.key))

    def judged(self, value: float | None) -> str:
        """Verdict, by how much a number meets or misses the bound; empty without one of them."""
        if value is None or self.bound is None:
            return ""
        ahead = value - self.bound if self.least else self.bound - value
        return f"{'met' if ahead >= 0 else 'not met'}, by {_by(abs(ahead), self.unit)}"


VARIANCE = Goal("variance_10_modes", "variance held by ten modes", "share", 0.992, True, True)
RECONSTRUCTION = tuple(
    Goal(f"table1.{p.key}", f"reconstruction from {p.label}", "error", p.paper, paper=True)
    for p in TABLE_1
)
ITERATIONS = Goal(
    "iterations_to_converge",
    "iterations to converge from the blob, by forces",
    "count",
    15,
    paper=True,
)
CONVERGED = Goal("blob.converged", "share of all frames that do within 15", "share", 1, True)
KNOWN = Goal("pose.known", "lip error, pose known, all cameras", "mm", 1.0)
WORST = Goal("pose.worst", "the same, the worst person and camera", "mm", 1.0)
FRONTAL = Goal("pose.frontal", "lip error, pose known, frontal camera", "mm", 0.8)
POSES = (
    KNOWN,
    WORST,
    FRONTAL,
    Goal("pose.blob", "lip error by forces, placed by the lip blob, all cameras", "mm", None),
    Goal("pose.blob_frontal", "the same, frontal camera", "mm", None),
    Goal("pose.estimated", "lip error, pose estimated, moving head", "mm", 1.5),
    Goal("pose.estimated_worst", "the same, the worst person", "mm", 1.5),
)
RECORDED = Goal(
    "recorded.all.mm", "lip error, learned from a recording, in other motion, frontal", "mm", None
)
FURTHER_LEFT = Goal(
    "further_training.left", "lip error after further training, of that before", "share", 0.75
)
GRID = (
    Goal("grid.closure_precision", "GRID closures, precision", "share", 0.9, True),
    Goal("grid.closure_recall", "GRID closures, recall", "share", 0.9, True),
    Goal("grid.closures_missed", "GRID closures without a closed frame", "count", 0),
    Goal("grid.spikes", "GRID apertures, single-frame spikes", "count", 0),
)
GOALS = (VARIANCE, *RECONSTRUCTION, RECORDED, *POSES, ITERATIONS, CONVERGED, FURTHER_LEFT, *GRID)


def told(value: float | None, unit: Unit) -> str:
    """A number with its unit, or that it was not measured."""
    return MISSING if value is None else _FORMATS[unit](value)


def remark(results: Results, goal: Goal) -> str:
    """Verdict on a goal and by how much, or why closures of recordings are missing."""
    if goal in GRID and number(results, goal.key) is None:
        return "left out by --quick" if results.get("quick") else "recordings not there"
    return goal.verdict(results)


def score_lines(results: Results) -> list[str]:
    """The main numbers for a terminal."""
    lines = [f"{'':40}{'here':>14}  paper or goal"]
    for goal in GOALS:
        measured, aim = goal.told(results), goal.aim()
        line = f"{goal.name:40}{measured:>14}  {aim:20}{remark(results, goal)}"
        lines.append(line.rstrip())
    return lines


def _by(distance: float, unit: Unit) -> str:
    return f"{100 * distance:.2f} points" if unit == "share" else _FORMATS[unit](distance)
