"""Cells of a CSV of markers: column names, and numbers with a line for each frame."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import InputFileError
from abs_engine.io.csv_table import check_separators
from abs_engine.io.inputs import to_number

_OWN = ("frame", "time", "point", "x", "y", "z")
"""Columns that are not named for a marker; capitals do not matter in them."""


def read_cells(path: Path) -> tuple[list[str], FloatArray]:
    """Column names, and numbers (T, columns) with NaN for empty cells.

    Lines for each marker (``frame``, ``point``, ``x``, ``y``, ``z``) become one for each frame,
    with ``NAME_x``, ``NAME_y``, ``NAME_z``.

    Raises
    ------
    InputFileError
        If the file is no CSV, has no column names, or a line is cut or holds what is no number.
    """
    try:
        rows = [r for r in csv.reader(path.read_text("utf-8-sig").splitlines()) if any(r)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputFileError(f"{path} is not a CSV file", "give C3D or CSV") from error
    if len(rows) < 2:
        raise InputFileError(f"{path} holds no markers", "give column names and frames")
    header = _header(path, rows[0])
    if "point" in header:
        header, rows = _widened(path, header, rows[1:])
    else:
        rows = rows[1:]
    table = np.full((len(rows), len(header)), np.nan)
    for k, row in enumerate(rows):
        if len(row) != len(header):
            raise InputFileError(
                f"{path}, frame {_frame(header, row, k)} has {len(row)} values for {len(header)} "
                "columns",
                "check the file: use commas only between columns, and decimal points in numbers",
            )
        try:
            table[k] = [to_number(cell, gaps=True) for cell in row]
        except ValueError as error:
            raise InputFileError(
                f"{path}, frame {_frame(header, row, k)}: {error}", "give numbers"
            ) from error
    return header, table


def _frame(header: list[str], row: list[str], k: int) -> str:
    """Number of row `k`'s frame: by the column ``frame`` where there is one, else from 0."""
    at = header.index("frame") if "frame" in header else len(row)
    try:
        return f"{to_number(row[at]):.12g}" if at < len(row) else str(k)
    except ValueError:
        return str(k)


def _header(path: Path, row: list[str]) -> list[str]:
    """Column names in the first row; raises where it holds none."""
    check_separators(path, row)
    if any(_is_number(cell) for cell in row):
        raise InputFileError(
            f"{path} has no column names in its first line",
            "add them, such as frame,point,x,y,z",
        )
    names = [name.strip() for name in row]
    return [name.lower() if name.lower() in _OWN else name for name in names]


def _is_number(cell: str) -> bool:
    try:
        to_number(cell)
    except ValueError:
        return False
    return True


def _widened(
    path: Path, header: list[str], rows: list[list[str]]
) -> tuple[list[str], list[list[str]]]:
    """A line for each frame, of lines for each marker."""
    key = next((k for k in ("frame", "time") if k in header), None)
    if key is None:
        raise InputFileError(f"{path} has no column frame or time", "give one of them")
    lacking = [name for name in "xyz" if name not in header]
    if lacking:
        raise InputFileError(
            f"{path} has no column {lacking[0]}", "give frame or time, point, x, y and z"
        )
    at = {name: header.index(name) for name in (key, "point", "x", "y", "z")}
    names: dict[str, None] = {}
    frames: dict[float, dict[str, list[str]]] = {}
    for number, row in enumerate(rows, start=2):
        if len(row) < len(header):
            raise InputFileError(
                f"{path}, line {number} has {len(row)} of {len(header)} values",
                "check the file: it may have been cut",
            )
        try:
            when, name = to_number(row[at[key]]), row[at["point"]].strip()
            here = frames.setdefault(when, {})
            if name in here:
                raise ValueError(f"'{name}' is given twice")
            here[name] = [row[at[c]] for c in "xyz"]
        except ValueError as error:
            raise InputFileError(f"{path}, line {number}: {error}", "check the file") from error
        names[name] = None
    wide = [key, *(f"{n}_{c}" for n in names for c in "xyz")]
    empty = ["", "", ""]
    return wide, [
        [repr(when), *(cell for n in names for cell in frames[when].get(n, empty))]
        for when in sorted(frames)
    ]
