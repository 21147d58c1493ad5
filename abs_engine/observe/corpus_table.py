"""The table that says which recorded points are lips, jaw and teeth, and which frames are what."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from abs_engine.errors import InputFileError

HOW = "see 'abs-engine articulate --help'"
_TEETH = ("right", "left", "front")
_COLUMNS = ("what", "name", "value")


@dataclass(frozen=True)
class CorpusTable:
    """What the points are, and which frame is which viseme.

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
        If it is missing, or not of this form.
    """
    path = Path(path)
    if not path.is_file():
        raise InputFileError(f"{path} does not exist", "check the path")
    try:
        text = path.read_text("utf-8-sig")
        return _from_json(text) if path.suffix.lower() == ".json" else _from_csv(text)
    except (OSError, UnicodeDecodeError, csv.Error, ValueError, KeyError, TypeError,
            AttributeError) as error:  # fmt: skip
        raise InputFileError(f"{path} is no table of a corpus ({error})", HOW) from error


def _from_json(text: str) -> CorpusTable:
    told: dict[str, Any] = json.loads(text)
    groups = {str(g): tuple(map(str, names)) for g, names in told["groups"].items()}
    visemes = {str(v): _span(frames) for v, frames in told.get("visemes", {}).items()}
    return _checked(groups, visemes, tuple(map(str, told.get("upper_teeth", ()))))


def _from_csv(text: str) -> CorpusTable:
    groups: dict[str, tuple[str, ...]] = {}
    visemes: dict[str, tuple[int, int]] = {}
    teeth: dict[str, str] = {}
    reader = csv.DictReader(text.splitlines())
    if not set(_COLUMNS) <= set(reader.fieldnames or ()):
        raise ValueError(f"the first line is not {','.join(_COLUMNS)}")
    for row in reader:
        what, name, value = ((row[key] or "").strip() for key in _COLUMNS)
        line = f"line {reader.line_num}"
        if what == "point":
            for group in value.split():
                groups[group] = (*groups.get(group, ()), name)
        elif what == "viseme":
            if name in visemes:
                raise ValueError(f"{line}: viseme '{name}' is given twice")
            visemes[name] = _frames(value, line)
        elif what == "teeth" and name in _TEETH:
            teeth[name] = value
        else:
            raise ValueError(f"{line}: '{what}' '{name}'")
    return _checked(groups, visemes, tuple(teeth.get(k, "") for k in _TEETH) if teeth else ())


def _frames(text: str, line: str) -> tuple[int, int]:
    try:
        return _span([int(part) for part in text.split("-")])
    except ValueError as error:
        raise ValueError(f"{line}: '{text}' are no frames, such as 12 or 30-34") from error


def _span(frames: Any) -> tuple[int, int]:
    given = [frames] if isinstance(frames, int) else [int(f) for f in frames]
    if len(given) not in (1, 2) or not 0 <= given[0] <= given[-1]:
        raise ValueError(f"frames {frames}")
    return given[0], given[-1]


def _checked(
    groups: Mapping[str, tuple[str, ...]],
    visemes: Mapping[str, tuple[int, int]],
    teeth: tuple[str, ...],
) -> CorpusTable:
    if teeth and len(set(teeth) - {""}) != len(_TEETH):
        raise ValueError("upper_teeth are three points: right, left, front")
    return CorpusTable(groups, visemes, teeth)
