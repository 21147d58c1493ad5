"""The table that says which recorded points are lips, jaw and teeth, and which frames are what."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from abs_engine.core.errors import InputFileError
from abs_engine.io.csv_table import Table
from abs_engine.io.csv_table import read_table as read_cells
from abs_engine.io.inputs import name_problem, parse_json, read_text

HOW = "see 'abs-engine articulate --help'"
_TEETH = ("right", "left", "front")
_COLUMNS = ("what", "name", "value")


@dataclass(frozen=True)
class CorpusTable:
    """Names of the points, and the viseme of each frame.

    Parameters
    ----------
    groups : mapping of str to tuple of str
        Names of points by group.
    visemes : mapping of str to tuple of int
        First and last frame of each, both included; the first frame of the file is 0.
    upper_teeth : tuple of str
        Points on a right molar, a left molar and the front teeth, which the bite plane is set by;
        empty where the points are in its frame already.
    """

    groups: Mapping[str, tuple[str, ...]]
    visemes: Mapping[str, tuple[int, int]]
    upper_teeth: tuple[str, ...] = field(default=())


def read_table(path: Path) -> CorpusTable:
    """Read a table of points and visemes, JSON by its suffix, else CSV.

    JSON: ``{"groups": {"lips": ["m1", ...], ...}, "visemes": {"ipi": 12, "a": [30, 34]},
    "upper_teeth": ["right", "left", "front"]}``. CSV: the columns ``what,name,value`` with lines
    such as ``point,m1,lips upper_lip``, ``viseme,ipi,12``, ``viseme,a,30-34`` and
    ``teeth,front,m80``.

    Raises
    ------
    InputFileError
        If it is missing, not of this form, gives something twice, or has names that cannot be
        printed.
    """
    path = Path(path)
    try:
        if path.suffix.lower() == ".json":
            return _from_json(read_text(path, HOW))
        return _from_csv(read_cells(path, small=True, remedy=HOW))
    except ValueError as error:
        raise InputFileError(f"{path} is not a table of a corpus ({error})", HOW) from error


def _from_json(text: str) -> CorpusTable:
    told = parse_json(text)
    if not isinstance(told, dict) or not isinstance(told.get("groups"), dict):
        raise ValueError("there are no groups")
    groups = {group: _texts(f"group {group!r}", names) for group, names in told["groups"].items()}
    given = told.get("visemes", {})
    if not isinstance(given, dict):
        raise ValueError("visemes are not names with frames")
    visemes = {viseme: _span(viseme, frames) for viseme, frames in given.items()}
    return _checked(groups, visemes, _texts("upper_teeth", told.get("upper_teeth", [])))


def _texts(what: str, names: Any) -> tuple[str, ...]:
    """A JSON list of names; a text alone would pass for a list of its letters."""
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise ValueError(f"{what} is not a list of names of points")
    return tuple(names)


def _from_csv(table: Table) -> CorpusTable:
    groups: dict[str, tuple[str, ...]] = {}
    visemes: dict[str, tuple[int, int]] = {}
    teeth: dict[str, str] = {}
    if not set(_COLUMNS) <= set(table.columns):
        raise ValueError(f"the first line is not {','.join(_COLUMNS)}")
    for number, row in table.cells():
        what, name, value = (row[key] for key in _COLUMNS)
        what, line = what.lower(), f"line {number}"
        if what == "point":
            for group in value.split():
                groups[group] = (*groups.get(group, ()), name)
        elif what == "viseme":
            if name in visemes:
                raise ValueError(f"{line}: viseme {name!r} is given twice")
            visemes[name] = _frames(value, line)
        elif what == "teeth" and name in _TEETH:
            if name in teeth:
                raise ValueError(f"{line}: the {name} teeth are given twice")
            teeth[name] = value
        else:
            raise ValueError(f"{line}: {what!r} {name!r}")
    return _checked(groups, visemes, tuple(teeth.get(k, "") for k in _TEETH) if teeth else ())


def _frames(text: str, line: str) -> tuple[int, int]:
    try:
        return _span(line, [int(part) for part in text.split("-")])
    except ValueError as error:
        raise ValueError(f"{line}: {text!r} are not frames, such as 12 or 30-34") from error


def _span(viseme: str, frames: Any) -> tuple[int, int]:
    """First and last frame, of one number or a list; of nothing that merely turns into numbers."""
    given = frames if isinstance(frames, list) else [frames]
    whole = all(type(f) is int for f in given)  # true is an int to Python
    if not whole or len(given) not in (1, 2) or not 0 <= given[0] <= given[-1]:
        raise ValueError(f"viseme {viseme!r} has no frames such as 12 or [30, 34]")
    return given[0], given[-1]


def _checked(
    groups: Mapping[str, tuple[str, ...]],
    visemes: Mapping[str, tuple[int, int]],
    teeth: tuple[str, ...],
) -> CorpusTable:
    named = (
        ("group", tuple(groups)),
        ("viseme", tuple(visemes)),
        *(("point", p) for p in groups.values()),
        ("point", tuple(name for name in teeth if name)),
    )
    for what, names in named:
        problems = [p for p in (name_problem(what, name) for name in names) if p]
        if problems:
            raise ValueError(problems[0])
    for group, points in groups.items():
        twice = [name for k, name in enumerate(points) if name in points[:k]]
        if twice:
            raise ValueError(f"point {twice[0]!r} is given twice in group {group!r}")
    if teeth and len(set(teeth) - {""}) != len(_TEETH):
        raise ValueError("upper_teeth are three points: right, left, front")
    return CorpusTable(groups, visemes, teeth)
