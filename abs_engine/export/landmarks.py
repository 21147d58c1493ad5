"""68 landmarks in pixels as a table, a line for each point."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from abs_engine.export.exporter import Exporter, Loss, TrackedRun
from abs_engine.export.reading import compared, numbers
from abs_engine.tracking.results.run_table import time_cell


def _write(run: TrackedRun, path: Path) -> tuple[Loss, ...]:
    points = run.landmarks_in_picture
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(["frame", "time", "point", "x", "y", "unit"])
        for frame, places in enumerate(points):
            time = time_cell(run.arrays["time"][frame])
            for number, (x, y) in enumerate(places):
                cells = ["", ""] if np.isnan(x) else [f"{x:.3f}", f"{y:.3f}"]
                table.writerow([frame, time, number, *cells, "px"])
    read = numbers(path, ["time", "x", "y"]).reshape(len(run), -1, 3)
    return (
        compared(read[:, 0, 0], run.arrays["time"], "s", "times"),
        compared(read[..., 1:], points, "px", "68 landmarks"),
    )


LANDMARKS = Exporter(
    "68 landmarks in pixels, in 300-W's order, a line for each point", _write, ".csv"
)
