"""Scores side by side: for the terminal, as JSON and as CSV."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import Any

from abs_engine.evaluate.catalogue import Metric, catalogue
from abs_engine.evaluate.score import Score

FORMAT, VERSION = "abs_engine.scores", 1
IN_BRACKETS = "In brackets: the 95 % confidence interval, by a bootstrap over blocks of frames."
Systems = Mapping[str, Mapping[str, Score]]


def used(systems: Iterable[Mapping[str, Score]]) -> list[Metric]:
    """Metrics that any of some systems has, in the catalogue's order."""
    have = {key for scores in systems for key in scores}
    return [metric for metric in catalogue() if metric.key in have]


def lines(systems: Systems) -> list[str]:
    """The table for a terminal: a row for each metric, a column for each system.

    The 95 % confidence interval is in brackets. Shares are in percent.
    """
    rows = [["", *systems]]
    for metric in used(systems.values()):
        cells = [shown(metric, scores.get(metric.key)) for scores in systems.values()]
        rows.append([title(metric), *(" ".join(cell).rstrip() for cell in cells)])
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return ["  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)) for row in rows]


def as_json(systems: Systems, facts: Mapping[str, Any]) -> str:
    """``scores.json``: every number with its interval, and what it means; and some facts."""
    told = {
        "format": FORMAT,
        "version": VERSION,
        **facts,
        "metrics": {
            m.key: {"label": m.label.strip(), "unit": m.unit, "definition": m.definition}
            for m in used(systems.values())
        },
        "systems": {name: as_values(scores) for name, scores in systems.items()},
    }
    return json.dumps(told, indent=1, allow_nan=False) + "\n"


def as_values(scores: Mapping[str, Score]) -> dict[str, dict[str, float | None]]:
    """Scores as JSON values: each number with its interval, None where there is none."""
    return {
        key: {k: None if math.isnan(number) else number for k, number in asdict(score).items()}
        for key, score in scores.items()
    }


def as_csv(systems: Systems) -> str:
    """``scores.csv``: a line for each system and metric."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["system", "metric", "unit", "value", "low", "high"])
    for name, scores in systems.items():
        for metric in used([scores]):
            score = scores[metric.key]
            numbers = (score.value, score.low, score.high)
            shown = ["" if math.isnan(n) else f"{n:.6g}" for n in numbers]
            writer.writerow([name, metric.key, metric.unit, *shown])
    return text.getvalue()


def title(metric: Metric) -> str:
    """Label of a metric with its unit."""
    return metric.label + (f" ({shown_unit(metric)})" if metric.unit else "")


def shown_unit(metric: Metric) -> str:
    """The unit in which people are shown a metric: percent for a share."""
    return "%" if metric.unit == "share" else metric.unit


def shown(metric: Metric, score: Score | None) -> tuple[str, str]:
    """A score in `shown_unit`, "-" where there is none, and its interval in brackets, if any."""
    if score is None or math.isnan(score.value):
        return "-", ""
    times = 100 if metric.unit == "share" else 1
    middle, low, high = (_short(times * n) for n in (score.value, score.low, score.high))
    return middle, "" if math.isnan(score.low) else f"[{low}, {high}]"


def _short(number: float) -> str:
    """Three digits after the point, fewer where the number is large, none where it is whole."""
    if math.isnan(number) or math.isclose(number, round(number)) or abs(number) >= 1000:
        return f"{number:.0f}"
    digits = 2 if abs(number) >= 10 else 3
    return f"{round(number, digits) + 0.0:.{digits}f}"  # + 0.0: no -0.000
