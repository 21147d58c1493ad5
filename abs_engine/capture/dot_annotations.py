"""Places of dots that a person gives: where they are at first, and corrections later on."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import InputFileError, ModelFormatError, TooFewPointsError
from abs_engine.io.csv_table import read_table
from abs_engine.io.inputs import MOST, parse_json, read_text, to_number

FORMAT, VERSION = "abs_engine.dots", 1

LIPS16 = (
    "corner_right",
    *(f"upper_outer_{k}" for k in range(1, 4)),
    "corner_left",
    *(f"lower_outer_{k}" for k in range(1, 4)),
    *(f"upper_inner_{k}" for k in range(1, 5)),
    *(f"lower_inner_{k}" for k in range(1, 5)),
)
"""Dots of the lips: eight around the mouth just inside the outer border, the corners among them,
then four on each lip as near to where the lips meet as can be seen with the mouth closed.

Each row is counted from the subject's right to the left.
"""
LIPS17 = (*LIPS16, "nose")
"""With the tip of the nose: the number of dots of Basu, Oliver and Pentland (1998), figure 1."""

_REMEDY = "give columns frame, view, point, x, y (frame from 0, view from 1)"
_EMPTY = ("", "nan", "null", "none")


@dataclass(frozen=True)
class Mark:
    """Place at which a person sees a dot.

    Parameters
    ----------
    frame : int, from 0
    view : int, from 0
    point : str
        Name of the dot.
    place : (float, float) or None
        x and y in pixels, or None: the dot cannot be seen in this frame.
    """

    frame: int
    view: int
    point: str
    place: tuple[float, float] | None


def read_marks(path: Path) -> tuple[Mark, ...]:
    """Read a CSV or JSON file of marks.

    A CSV has the columns ``point``, ``x``, ``y`` and perhaps ``frame`` (default 0) and ``view``
    (counted from 1, default 1); further columns are ignored. x and y are pixels, the centre of
    the top left pixel is 0, 0; both empty: the dot is not seen. A JSON file holds the same under
    ``points``, beside ``format`` "abs_engine.dots" and ``version`` 1.

    Raises
    ------
    InputFileError
        If the file is missing, is neither, lacks a column, a value is no number, or a point is
        given twice for a frame and a view.
    ModelFormatError
        If a JSON file has another format or version.
    """
    path = Path(path)
    rows = _json_rows(path) if path.suffix.lower() == ".json" else _csv_rows(path)
    marks: dict[tuple[int, int, str], Mark] = {}
    for line, row in rows:
        mark = _mark(path, line, row)
        key = mark.frame, mark.view, mark.point
        if key in marks:
            raise InputFileError(
                f"{path}, {line}: point '{mark.point}' is given twice for frame {mark.frame} and "
                f"view {mark.view + 1}",
                "keep one",
            )
        marks[key] = mark
    if not marks:
        raise InputFileError(f"{path} holds no points", _REMEDY)
    return tuple(marks.values())


def write_marks(rows: Iterable[tuple[Mark, Mapping[str, object]]]) -> str:
    """The text of a CSV file that `read_marks` reads, with further columns for a person to read.

    These are the same in each row.
    """
    out, given = io.StringIO(), list(rows)
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["frame", "view", "point", "x", "y", *(given[0][1] if given else ())])
    for mark, more in given:
        place = ("", "") if mark.place is None else [f"{c:.2f}" for c in mark.place]
        writer.writerow([mark.frame, mark.view + 1, mark.point, *place, *more.values()])
    return out.getvalue()


def needed_among(names: Iterable[str]) -> tuple[str, ...]:
    """Dots that there must be: `LIPS17` where any of the lips' is named, else none."""
    return LIPS17 if set(names) & set(LIPS16) else ()


def initial_places(marks: Sequence[Mark], views: int) -> tuple[tuple[str, ...], FloatArray]:
    """Names of the dots and where each is in the first frame.

    Parameters
    ----------
    marks : sequence of Mark
        Only those of frame 0 are looked at.

    Returns
    -------
    names : tuple of str
        Those that must be there, see `needed_among`, come first.
    places : (V, N, 2) float64, px

    Raises
    ------
    TooFewPointsError
        If no mark is in frame 0, or a needed dot, or a dot of another view, has no place in one
        of the views.
    ModelFormatError
        If a mark is in a view that there is not, or a dot is given twice.
    """
    first = [m for m in marks if m.frame == 0]
    if not first:
        raise TooFewPointsError(
            "no place is given for frame 0 (frames count from 0)",
            "give every dot in every view in frame 0",
        )
    needed = needed_among(m.point for m in first)
    names = tuple(dict.fromkeys([*needed, *(m.point for m in first)]))
    places = np.full((views, len(names), 2), np.nan)
    for mark in first:
        check_view(mark, views)
        at = mark.view, names.index(mark.point)
        if np.isfinite(places[at]).any():
            raise ModelFormatError(
                f"point '{mark.point}' is given twice for view {mark.view + 1}", "keep one"
            )
        if mark.place is not None:
            places[at] = mark.place
    view, point = np.nonzero(np.isnan(places).any(axis=2))
    if len(view):
        lacking = ", ".join(f"{names[p]} (view {v + 1})" for v, p in zip(view, point, strict=True))
        raise TooFewPointsError(
            f"{len(view)} places are missing in frame 0: {_short(lacking)}",
            "give every dot in every view in frame 0",
        )
    return names, places


def check_view(mark: Mark, views: int) -> None:
    """Raise `ModelFormatError` if the mark is in a view that there is not."""
    if not 0 <= mark.view < views:
        raise ModelFormatError(
            f"point '{mark.point}' is given for view {mark.view + 1}", f"there are {views} views"
        )


def _short(text: str, most: int = 120) -> str:
    return text if len(text) <= most else f"{text[:most]}..."


def _json_rows(path: Path) -> list[tuple[str, Mapping[str, object]]]:
    text = read_text(path, _REMEDY)
    try:
        told = parse_json(text)
        kind, rows = (told.get("format"), told.get("version")), told["points"]
    except (ValueError, KeyError, AttributeError) as error:
        raise InputFileError(f"{path} is not a JSON file of points", _REMEDY) from error
    if kind != (FORMAT, VERSION) or type(kind[1]) is not int:
        raise ModelFormatError(
            f"{path} is {kind[0]} version {kind[1]}, wanted {FORMAT} {VERSION}",
            "state both in the file",
        )
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise InputFileError(f"{path} has no list of points", _REMEDY)
    return [(f"point {k + 1}", row) for k, row in enumerate(rows)]


def _csv_rows(path: Path) -> list[tuple[str, Mapping[str, object]]]:
    table = read_table(path, small=True, remedy=_REMEDY)
    table.require(("point", "x", "y"), _REMEDY)
    return [(f"line {line}", row) for line, row in table.cells()]


def _mark(path: Path, line: str, row: Mapping[str, object]) -> Mark:
    named = row.get("point")
    point = named.strip() if isinstance(named, str) else ""
    try:
        frame, view = (
            _whole(str(row.get(k) if row.get(k) not in (None, "") else d))
            for k, d in (("frame", 0), ("view", 1))
        )
        values = [str("" if row.get(k) is None else row[k]).strip().lower() for k in ("x", "y")]
        empty = [v in _EMPTY for v in values]
        place = None if all(empty) else (to_number(values[0]), to_number(values[1]))
    except ValueError as error:
        raise InputFileError(f"{path}, {line}: {error}", _REMEDY) from error
    if not point or not 0 <= frame <= MOST:
        raise InputFileError(f"{path}, {line} names no point, frame or place", _REMEDY)
    return Mark(frame, view - 1, point, place)


def _whole(cell: str) -> int:
    number = to_number(cell)
    if not number.is_integer():
        raise ValueError(f"{cell!r} is not a whole number")
    return int(number)
