"""Face-unit files of other systems, as Live Link Face writes them for ARKit.

A line for each frame: the 52 weights under ARKit's names (``JawOpen`` or ``jawOpen``), and perhaps
``Timecode`` (hours:minutes:seconds:frames) and ``HeadYaw``,
``HeadPitch``, ``HeadRoll``, radians, see `head_angles`. The vertices are those of the filmed person
with the weights on the bundled head's units.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.dataset.head_angles import rotation_by
from abs_engine.dataset.timecode import seconds, steadied
from abs_engine.evaluate.estimate import Areas, Estimate, PointTrack
from abs_engine.evaluate.landmark_csv import Reference, rotation_vectors
from abs_engine.evaluate.metrics.curves import landmark_curves
from abs_engine.face.schema import Unit
from abs_engine.io.assets import CLOSED_APERTURE
from abs_engine.io.csv_table import Table, read_table
from abs_engine.tracking.results.run_mesh import LinearSurface

HEAD = ("headyaw", "headpitch", "headroll")
DRIFT = 0.002
"""Share by which timecodes may be off: they count 30 frames where 29.97 are taken in a second."""

WIDEST = 1.5
"""Usual steps between two rows with timecodes, between which no row was lost."""

LEAST, LARGEST = -0.1, 1.5
"""ARKit's weights lie between 0 and 1; beyond these, which a filter may reach, they are something
else, such as per cent. Chosen."""


def read_arkit(
    path: Path, clip: Reference, unit_names: Sequence[str], units: NDArray[Any], areas: Areas
) -> Estimate:
    """Read a file of face units as an estimate of a clip.

    Parameters
    ----------
    unit_names : sequence of 52 str
    units : (52, V, 3) float, mm at weight 1
    areas : mapping of str to vertex indices
        `landmark_68` and those that are scored as tracks of their own.

    Raises
    ------
    InputFileError
        If units are missing or a cell is no number.
    ParameterError
        If it is of other frames than the clip.
    """
    table = read_table(path, empty_lines=True)
    table = replace(table, columns={k.lower(): v for k, v in table.columns.items()})
    table = _without_end(table, clip.frames)
    table.require(name.lower() for name in unit_names)
    head = HEAD if all(name in table.columns for name in HEAD) else ()
    numbers = table.numbers([*(name.lower() for name in unit_names), *head])
    numbers = _on_frames(table, numbers, clip)
    weights = numbers[:, : len(unit_names)]
    _check_range(f"a weight of {path}", weights, (LEAST, LARGEST), "give weights from 0 to 1")
    turns = numbers[:, len(unit_names) :]
    _check_range(f"a head angle of {path}", turns, (-2 * np.pi, 2 * np.pi), "give radians")
    surface = LinearSurface(clip.neutral, units, weights)
    scored = {k: v for k, v in areas.items() if k != "landmark_68"}
    curves = landmark_curves(surface.points(clip.landmark_68))
    return Estimate(
        name=Path(path).stem,
        found=np.asarray(np.isfinite(weights).all(axis=1)),
        tracks={k: PointTrack(v, surface.points(v)) for k, v in scored.items()},
        rotations=rotation_vectors(turns, rotation_by) if head else None,
        turned="camera",
        curves=curves,
        closed=np.asarray(curves["aperture"] < CLOSED_APERTURE),
        closed_by="aperture",
        surface=surface,
    )


def is_arkit(columns: Sequence[str]) -> bool:
    """Whether a file with these columns holds face units."""
    return Unit.JAW_OPEN.lower() in {name.lower() for name in columns}


def _check_range(what: str, values: FloatArray, limits: tuple[float, float], remedy: str) -> None:
    """Raise `InputFileError` for the first value outside of the limits; NaN is none."""
    wrong = values[(values < limits[0]) | (values > limits[1])]
    if len(wrong):
        raise InputFileError(f"{what} is {wrong[0]:.3g}", remedy)


def _without_end(table: Table, frames: int) -> Table:
    """The table without the empty lines at its end that are more than the frames."""
    count = len(table.rows)
    while count > max(frames, 1) and not any(cell.strip() for cell in table.rows[count - 1]):
        count -= 1
    return replace(table, rows=table.rows[:count], lines=table.lines[:count])


def _on_frames(table: Table, numbers: FloatArray, clip: Reference) -> FloatArray:
    """Rows (T, ...) at the times of the frames; NaN where they were lost.

    As many rows as frames are the frames, if timecodes do not deny it; otherwise the timecodes,
    from the first on, or from 0 if that fits the clip better, must cover the clip, and rows are
    interpolated where none is missing.
    """
    if len(numbers) == clip.frames:
        _check_duration(table, clip)
        return numbers
    problem = f"{table.path} has {len(numbers)} rows, the truth {clip.frames} frames"
    remedy = "give a row for each frame, or timecodes that cover the clip"
    if "timecode" not in table.columns:
        raise ParameterError(problem, remedy)
    coded = np.array([bool(code) for code in table.text("timecode")])
    said = np.isfinite(numbers).any(axis=1) | coded
    times, numbers = _seconds(table, np.flatnonzero(said).tolist()), numbers[said]
    wanted = np.arange(clip.frames) / clip.rate
    begun = times[0] if len(times) else 0.0
    times = times - begun
    lasts = times[-1] if len(times) > 1 else 0.0
    if abs(begun + lasts - wanted[-1]) >= abs(lasts - wanted[-1]):
        begun = 0.0  # else the first rows are missing
    off = abs(begun + lasts - wanted[-1])
    if (np.diff(times) <= 0).any() or not lasts or off > 1.5 / clip.rate:
        raise ParameterError(f"{problem}, and lasts {lasts:.2f} s", remedy)
    times = steadied(times) + begun
    step = float(np.median(np.diff(times)))
    return np.stack([_between(wanted, times, column, step) for column in numbers.T], axis=1)


def _between(wanted: FloatArray, times: FloatArray, column: FloatArray, step: float) -> FloatArray:
    """A column at wanted times; NaN in gaps, as far as they are not beside a row.

    A row stands for what is less than half a usual step from it, at both ends for what is less
    than a whole one.
    """
    known = np.isfinite(column)
    if not known.any():
        return np.full(len(wanted), np.nan)
    times, column = times[known], column[known]
    at = np.searchsorted(times, wanted)
    before, after = times[np.maximum(at - 1, 0)], times[np.minimum(at, len(times) - 1)]
    away = np.minimum(np.abs(wanted - before), np.abs(wanted - after))
    whole = (after - before <= WIDEST * step) & (away < 0.9 * step)
    return np.where(whole | (away < 0.5 * step), np.interp(wanted, times, column), np.nan)


def _seconds(table: Table, rows: Sequence[int]) -> FloatArray:
    """Times (N,) of some rows, s after timecode 0, which must not go back."""
    codes = table.text("timecode")
    lines = [table.lines[row] for row in rows]
    times = seconds([codes[row] for row in rows], table.path, lines=lines)
    back = np.flatnonzero(np.diff(times) < 0)
    if len(back):
        raise InputFileError(
            f"line {lines[back[0] + 1]} of {table.path} has a timecode before the one above it",
            "sort the rows by their timecodes",
        )
    return times


def _check_duration(table: Table, clip: Reference) -> None:
    """Raise `ParameterError` if the timecodes last another time than the clip."""
    cells = table.text("timecode") if "timecode" in table.columns else []
    rows = [row for row, cell in enumerate(cells) if cell]
    times = _seconds(table, rows)
    wanted = (rows[-1] - rows[0]) / clip.rate if rows else 0.0
    if wanted < 1:
        return  # within a second the timecodes do not show how many frames they count
    lasts = float(times[-1] - times[0])
    if abs(lasts - wanted) > 1.5 / clip.rate + DRIFT * wanted:
        raise ParameterError(
            f"{table.path} lasts {lasts:.2f} s by its timecodes, the truth {wanted:.2f} s",
            "give results for this very clip",
        )
