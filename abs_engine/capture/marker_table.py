"""Tables of markers, CSV: a line for each frame, or one for each marker in it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import InputFileError
from abs_engine.io.csv_table import Table, read_table

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
    table = read_table(path, remedy="give C3D or CSV")
    names = {n.lower() if n.lower() in _OWN else n: k for n, k in table.columns.items()}
    table = replace(table, columns=names)
    if "point" in names:
        return _widened(table)
    return list(names), table.numbers(names, gaps=True)


def _widened(table: Table) -> tuple[list[str], FloatArray]:
    """A line for each frame, of lines for each marker."""
    keys = [k for k in ("frame", "time") if k in table.columns]
    if not keys:
        raise InputFileError(f"{table.path} has no column frame or time", "give one of them")
    table.require("xyz", "give frame or time, point, x, y and z")
    when, names, key = table.numbers(keys), table.text("point"), keys[0]
    markers = {name: k for k, name in enumerate(dict.fromkeys(names))}
    frames, first, rows = np.unique(when[:, 0], return_index=True, return_inverse=True)
    points = np.full((len(frames), len(markers), 3), np.nan)
    known = set()
    for line, row, name, place in zip(
        table.lines, rows.tolist(), names, table.numbers("xyz", gaps=True), strict=True
    ):
        if (row, name) in known or np.isnan(frames[row]):
            problem = f"no {key}" if np.isnan(frames[row]) else f"'{name}' is given twice"
            raise InputFileError(f"{table.path}, line {line}: {problem}", "check the file")
        known.add((row, name))
        points[row, markers[name]] = place
    header = [*keys, *(f"{name}_{axis}" for name in markers for axis in "xyz")]
    return header, np.column_stack([when[first], points.reshape(len(frames), -1)])
