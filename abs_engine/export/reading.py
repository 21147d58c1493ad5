"""Exports read back: the numbers of a written table, and their differences from the run."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import OutputError
from abs_engine.export.exporter import Loss, rms

UNDEFINED = "--undefined--"
"""Praat's word for an unknown number."""


def compared(
    read: ArrayLike, true: ArrayLike, unit: str, of: str, note: str = "", by: str = ""
) -> Loss:
    """Difference between numbers that are read back and a run's; NaN where unknown.

    Raises
    ------
    OutputError
        If some are missing, or there are too many.
    """
    given, wanted = np.asarray(read, np.float64), np.asarray(true, np.float64)
    if given.shape != wanted.shape or (np.isnan(given) != np.isnan(wanted)).any():
        raise differs(of)
    return Loss(rms(given - wanted), unit, of, note, by)


def differs(what: str) -> OutputError:
    """The error of a file that, read back, does not hold what was written."""
    return OutputError(
        f"the export, read back, does not have the run's {what}",
        "export again; if that fails, too, report a bug",
    )


def text_cells(path: Path, names: Sequence[str], delimiter: str = ",") -> Iterator[str]:
    """The cells under some names, row by row.

    Raises
    ------
    OutputError
        If a column is missing.
    """
    with path.open(encoding="utf-8", newline="") as file:
        rows = csv.reader(file, delimiter=delimiter)
        heading = next(rows)
        missing = set(names) - set(heading)
        if missing:
            raise differs(f"columns {', '.join(sorted(missing))}")
        places = [heading.index(name) for name in names]
        for row in rows:
            yield from (row[place] for place in places)


def numbers(path: Path, names: Sequence[str], delimiter: str = ",") -> FloatArray:
    """Columns of a table, (rows, columns); NaN where a cell is empty or undefined."""
    cells = text_cells(path, names, delimiter)
    known = (np.nan if cell in ("", UNDEFINED) else float(cell) for cell in cells)
    return np.fromiter(known, np.float64).reshape(-1, len(names))
