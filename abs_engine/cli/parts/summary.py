"""The lines that are printed at the end of a run."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from abs_engine.core.words import counted, each_counted


def summary_lines(summary: dict[str, Any], timing: dict[str, Any], said: str = "") -> Iterator[str]:
    """Counts, speed and warnings of a run, of its ``run.json`` and ``timing.json``.

    Warnings among the lines of `said`, which were printed before, are left out.
    """
    why = each_counted(summary.get("lost_reasons", {}))
    lost = f"{summary['lost_frames']} lost" + (f" ({why})" if why else "")
    against = summary.get("contradicted_frames", 0)
    doubted = f", {against} contradicted by landmarks" if against else ""
    yield (
        f"{counted(summary['frames'], 'frame')}, {lost}, "
        f"{summary['closed_frames']} with closed lips{doubted}; "
        f"{summary['mean_evaluations']:.0f} evaluations and "
        f"{timing['seconds_per_frame']:.3f} s a frame"
    )
    yield from warning_lines(summary, said)


def warning_lines(summary: dict[str, Any], said: str) -> Iterator[str]:
    """Warnings of a run that are not among the lines of `said`, which were printed before."""
    left = (line for line in summary.get("warnings", ()) if line not in said.splitlines())
    return (f"warning: {line}" for line in left)


def without_tuning(run: dict[str, Any]) -> dict[str, Any]:
    """A run's facts without the numbers that steer results, hundreds that ``run.json`` holds."""
    settings = {name: value for name, value in run["settings"].items() if name != "tuning"}
    return {**run, "settings": settings}
