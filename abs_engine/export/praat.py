"""Praat: closures as a TextGrid, and the measures beside it as a table that Praat and R read."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from praatio import textgrid
from praatio.data_classes.interval_tier import IntervalTier
from praatio.utilities.constants import Interval

from abs_engine.core.arrays import FloatArray
from abs_engine.export.exporter import Exporter, Loss, TrackedRun
from abs_engine.export.reading import UNDEFINED, compared, numbers
from abs_engine.tracking.run_table import time_cell

GRID, TABLE = "closures.TextGrid", "measures.tsv"
MEASURES = (
    "aperture", "width", "upper_protrusion", "lower_protrusion", "opening_area", "lip_area",
    "jaw_opening", "aperture_velocity", "width_velocity", "jaw_velocity", "head_pitch",
    "head_yaw", "head_roll",
)  # fmt: skip


def closures(run: TrackedRun) -> FloatArray:
    """Begin and end of each closure, (C, 2) s; where a moment is hidden, the frame's edge."""
    half = 0.5 / run.rate
    frames, times = run.arrays["closure_frames"], run.arrays["closure_times"]
    edges = run.arrays["time"][frames] + [-half, half] if len(frames) else np.zeros((0, 2))
    spans = np.where(np.isfinite(times), times, edges)
    if len(spans) and frames[-1, 1] == len(run.arrays["time"]) - 1:
        spans[-1, 1] = duration(run)  # closed to the end
    return np.clip(spans, 0.0, duration(run))


def duration(run: TrackedRun) -> float:
    """Length of the video, s."""
    return float(run.arrays["time"][-1]) + 1 / run.rate


def _write(run: TrackedRun, folder: Path) -> tuple[Loss, ...]:
    spans = closures(run)
    entries = [Interval(float(a), float(b), "closed") for a, b in spans if b > a]
    grid = textgrid.Textgrid()
    grid.addTier(IntervalTier("lips", entries, 0.0, duration(run)))
    grid.save(str(folder / GRID), format="long_textgrid", includeBlankSpaces=True)
    names = [name for name in MEASURES if name in run.arrays]
    with (folder / TABLE).open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, delimiter="\t", lineterminator="\n")
        table.writerow(["time", *names])
        for frame, time in enumerate(run.arrays["time"]):
            row = [float(run.arrays[name][frame]) for name in names]
            table.writerow([time_cell(time), *(_cell(x) for x in row)])
    read = numbers(folder / TABLE, ["time", *names], "\t")
    true = np.stack([run.arrays[name] for name in names], axis=1)
    return (
        _read_back(folder / GRID, spans),
        compared(read[:, 0], run.arrays["time"], "s", "times"),
        compared(read[:, 1:].ravel(), true.ravel(), "", "measures"),
    )


def _cell(number: float) -> str:
    return UNDEFINED if np.isnan(number) else f"{number:z.4f}"


def _read_back(path: Path, spans: FloatArray) -> Loss:
    tier = textgrid.openTextgrid(str(path), includeEmptyIntervals=False).getTier("lips")
    read = np.array([(one.start, one.end) for one in tier.entries]).reshape(-1, 2)
    spans = spans[spans[:, 1] > spans[:, 0]]
    return compared(read.ravel(), spans.ravel(), "s", "begins and ends of closures")


PRAAT = Exporter("a folder: closures as Praat's TextGrid, measures as a table", _write)
