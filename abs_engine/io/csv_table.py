"""Reads a CSV file of numbers: columns by name, errors by line and column."""

from __future__ import annotations

import csv
import difflib
import io
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import InputFileError
from abs_engine.core.words import counted
from abs_engine.io.inputs import read_text, to_number

EVALUATE_HELP = "for a run, give its folder; otherwise see 'abs-engine evaluate --help'"
_SEPARATORS = {";": "semicolons", "\t": "tabs"}
_COMMAS = "use commas only between columns, and decimal points in numbers"
_CELLS = "give a cell for every name, empty where nothing is known"


@dataclass(frozen=True)
class Table:
    """A CSV file as text.

    Parameters
    ----------
    columns : mapping of column name to its place
        Names as written, without spaces around them.
    lines : list of int
        The rows' line numbers in the file, from 1 on; blank lines count, too.
    """

    path: Path
    columns: dict[str, int]
    rows: list[list[str]]
    lines: list[int]

    def text(self, name: str) -> list[str]:
        """A column as text, without spaces around it."""
        place = self.columns[name]
        return [row[place].strip() for row in self.rows]

    def cells(self) -> Iterator[tuple[int, dict[str, str]]]:
        """Each row's line number, and its cells by column, without spaces around them."""
        for line, row in zip(self.lines, self.rows, strict=True):
            yield line, {name: row[place].strip() for name, place in self.columns.items()}

    def numbers(self, names: Iterable[str], *, gaps: bool = False) -> FloatArray:
        """Columns as numbers, (rows, columns); NaN where a cell is empty or, with `gaps`, says so.

        Raises
        ------
        InputFileError
            If a cell is no finite number; line and column are named.
        """
        wanted = list(names)
        out = np.full((len(self.rows), len(wanted)), np.nan)
        for k, name in enumerate(wanted):
            for row, cell in enumerate(self.text(name)):
                if cell:
                    out[row, k] = self._number(cell, self.lines[row], name, gaps)
        return out

    def _number(self, cell: str, line: int, name: str, gaps: bool) -> float:
        try:
            return to_number(cell, gaps=gaps)
        except ValueError as error:
            shown = " ".join(cell.split())[:60]
            raise InputFileError(
                f"{self.path}, line {line}: '{shown}' in column {name} is not a number",
                "give a number, or leave the cell empty",
            ) from error

    def require(self, names: Iterable[str], remedy: str = EVALUATE_HELP) -> None:
        """Raise `InputFileError` for columns that are missing, with the nearest name there is."""
        missing = [name for name in names if name not in self.columns]
        if not missing:
            return
        near = difflib.get_close_matches(missing[0], self.columns, 1)
        hint = f" (there is '{near[0]}')" if near else ""
        shown = ", ".join(missing[:5]) + (f" and {len(missing) - 5} more" if missing[5:] else "")
        raise InputFileError(f"{self.path} lacks the columns {shown}{hint}", remedy)


def read_table(
    path: Path,
    *,
    empty_lines: bool = False,
    small: bool = False,
    remedy: str = "give comma-separated text",
) -> Table:
    """Read a CSV file whose first line names its columns.

    Parameters
    ----------
    empty_lines : bool
        Keep lines whose cells are all empty, as a frame's of which nothing is known may be; by
        default they are left out, as spreadsheets end with such lines. Lines without a cell
        always are.
    small : bool
        Read the columns' names in small letters, however they are written.
    remedy : str
        What to do about a file that is not text.

    Raises
    ------
    InputFileError
        If it is missing, no text, empty, names no columns or one twice, has something other than
        commas between columns, or a line has too few or too many cells.
    """
    path = Path(path)
    reader = csv.reader(io.StringIO(read_text(path, remedy), newline=""), skipinitialspace=True)
    try:
        found = [
            (reader.line_num, row)
            for row in reader
            if any(cell.strip() for cell in row) or (empty_lines and len(row) > 1)
        ]
    except csv.Error as error:
        raise InputFileError(f"{path} is not a CSV file", remedy) from error
    if len(found) < 2:
        raise InputFileError(
            f"{path} has no line below its column names",
            "give a line of column names, and at least one below it",
        )
    (_, heading), *rest = found
    names = _names(path, heading, small)
    for line, row in rest:
        if len(row) != len(names):
            raise InputFileError(
                f"{path}, line {line}: {counted(len(row), 'cell')} under "
                f"{counted(len(names), 'name')}",
                _COMMAS if len(row) > len(names) else _CELLS,
            )
    columns = {name: k for k, name in enumerate(names)}
    return Table(path, columns, [row for _, row in rest], [line for line, _ in rest])


def _names(path: Path, heading: Sequence[str], small: bool) -> list[str]:
    """Names of the columns; raises `InputFileError` for a first line that does not name them."""
    marks = [word for mark, word in _SEPARATORS.items() if len(heading) == 1 and mark in heading[0]]
    if marks:
        raise InputFileError(
            f"{path} has {marks[0]} between its columns",
            "separate columns with commas, and use decimal points",
        )
    names = [name.strip().lower() if small else name.strip() for name in heading]
    if all(_is_number(name) for name in names if name):
        raise InputFileError(
            f"{path} has no column names in its first line", "add them, such as frame,point,x,y,z"
        )
    twice = [name for name in names if name and names.count(name) > 1]
    if twice:
        raise InputFileError(f"{path} has two columns {twice[0]}", "name every column once")
    return names


def _is_number(cell: str) -> bool:
    try:
        to_number(cell)
    except ValueError:
        return False
    return True
