"""Praat: closures as a TextGrid, and the measures beside it as a table that Praat and R read."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from praatio import textgrid
from praatio.data_classes.interval_tier import IntervalTier
from praatio.utilities.constants import Interval

from abs_engine.core.arrays import FloatArray, stretches
from abs_engine.export.exporter import Exporter, Loss, TrackedRun
from abs_engine.export.reading import UNDEFINED, compared, differs, numbers
from abs_engine.tracking.footage import sound_line
from abs_engine.tracking.frame.frame_times import usual_duration
from abs_engine.tracking.results.run_table import time_cell

GRID, TABLE = "closures.TextGrid", "measures.tsv"
MEASURES = (
    "aperture", "aperture_sd", "width", "width_sd", "upper_protrusion", "lower_protrusion",
    "opening_area", "lip_area", "jaw_opening", "aperture_velocity", "width_velocity",
    "jaw_velocity", "head_pitch", "head_yaw", "head_roll",
)  # fmt: skip
_HEARD = 0.0005  # s; less is 0 in the line about it


def closures(run: TrackedRun) -> FloatArray:
    """Begin and end of each closure, (C, 2) s; where a moment is hidden, the frame's edge."""
    frames, times = run.arrays["closure_frames"], run.arrays["closure_times"]
    spans = np.where(np.isfinite(times), times, _edges(run)[np.add(frames, (0, 1))])
    return np.clip(spans, 0.0, duration(run))


def lost(run: TrackedRun) -> FloatArray:
    """Begin and end of each stretch of frames without an aperture, (L, 2) s."""
    gone = np.array(stretches(np.isnan(run.arrays["aperture"])), np.int64)
    return _edges(run)[gone.reshape(-1, 2)]


def _edges(run: TrackedRun) -> FloatArray:
    """Begins of all frames, halfway from the one before, and the end of the last, (T + 1,) s."""
    time = run.arrays["time"]
    return np.concatenate([time[:1], 0.5 * (time[1:] + time[:-1]), [duration(run)]])


def duration(run: TrackedRun) -> float:
    """Length of the video, s."""
    time = run.arrays["time"]
    return float(time[-1]) + usual_duration(time, run.rate)


def _write(run: TrackedRun, folder: Path) -> tuple[Loss, ...]:
    marks = {"closed": closures(run), "lost": lost(run)}
    spans = [Interval(float(a), float(b), mark) for mark in marks for a, b in marks[mark]]
    entries = sorted(one for one in spans if one.end > one.start)
    grid = textgrid.Textgrid()
    grid.addTier(IntervalTier("lips", entries, 0.0, duration(run)))
    grid.save(str(folder / GRID), format="long_textgrid", includeBlankSpaces=True)
    names = [name for name in MEASURES if name in run.arrays]
    with (folder / TABLE).open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, delimiter="\t", lineterminator="\n")
        table.writerow(["time", *names])
        for frame, time in enumerate(run.arrays["time"]):
            row = [float(run.arrays[name][frame]) for name in names]
            table.writerow(
                [time_cell(time), *(UNDEFINED if np.isnan(x) else f"{x:z.4f}" for x in row)]
            )
    read = numbers(folder / TABLE, ["time", *names], "\t")
    true = np.stack([run.arrays[name] for name in names], axis=1)
    note = sound_line(run.sound, "these times") if abs(run.sound) >= _HEARD else ""
    return (
        _read_back(folder / GRID, entries),
        compared(read[:, 0], run.arrays["time"], "s", "times", note),
        compared(read[:, 1:].ravel(), true.ravel(), "", "measures (each in its own unit)"),
    )


def _read_back(path: Path, entries: list[Interval]) -> Loss:
    tier = textgrid.openTextgrid(str(path), includeEmptyIntervals=False).getTier("lips")
    if [one.label for one in tier.entries] != [one.label for one in entries]:
        raise differs("intervals")
    read, true = (np.ravel([one[:2] for one in some]) for some in (tier.entries, entries))
    return compared(read, true, "s", "interval boundaries")


PRAAT = Exporter("a folder: closures as Praat's TextGrid, measures as a table", _write)
