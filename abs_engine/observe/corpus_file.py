"""A user's own corpus: recorded points, and a table that says which are lips, jaw and teeth."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from abs_engine.errors import InputFileError, ModelFormatError, ParameterError, TooFewPointsError
from abs_engine.npz import format_of, read_arrays
from abs_engine.observe.corpus import FORMAT as CORPUS
from abs_engine.observe.corpus import Corpus, FloatArray, bite_plane, load_corpus
from abs_engine.observe.markers import UNITS, read_markers, refuse_infinite
from abs_engine.observe.observations import FORMAT as OBSERVATIONS
from abs_engine.observe.observations import read_observations

_TEETH = ("right", "left", "front")
_COLUMNS = ("what", "name", "value")
_HOW = "see 'abs-engine articulate --help'"


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


def read_corpus(
    path: Path, table: Path | None = None, rate: float | None = None, unit: str | None = None
) -> Corpus:
    """Read a corpus: a saved one, or C3D, CSV or NPZ with a table.

    Parameters
    ----------
    path : Path
        An ``.npz`` that is no saved corpus has observations, or plainly ``points`` (T, N, 3), mm,
        NaN where one is missing, and their ``names``.
    table : Path, optional
        See `read_table`; a saved corpus needs none.
    rate : float, optional
        Frames per second of a marker file that does not say; it does not matter to the corpus.
    unit : {"mm", "cm", "m"}, optional
        Of a marker file, or of plain arrays, which do not say; mm by default.

    Returns
    -------
    Corpus
        A viseme of several frames is their mean, over those in which a point is there.

    Raises
    ------
    InputFileError
        If a file is missing or cannot be read, or holds what is infinite.
    ModelFormatError
        If an ``.npz`` is neither a corpus nor observations.
    ParameterError
        If the table is lacking, or names points or frames that are not there; if a unit is given
        for what is in mm.
    TooFewPointsError
        If a point of the upper teeth is missing in a frame that is used.
    """
    path = Path(path)
    if path.suffix.lower() == ".npz" and table is None:
        _check_mm(path, unit)
        return load_corpus(path)
    if table is None:
        raise ParameterError(f"{path} does not say what its points are", f"give a table, {_HOW}")
    told = read_table(table)
    if path.suffix.lower() == ".npz":
        names, points = _read_npz(path, unit)
    else:
        markers = read_markers(path, _rate(path, rate), unit)
        names, points = markers.names, markers.points
    return _assembled(path, names, points, told)


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
        raise InputFileError(f"{path} is no table of a corpus ({error})", _HOW) from error


def _read_npz(path: Path, unit: str | None) -> tuple[tuple[str, ...], FloatArray]:
    """Names, and points (T, N, 3): of observations, or of an archive that holds just these."""
    arrays = read_arrays(path)
    if "format" in arrays:
        _check_mm(path, unit)
        if format_of(arrays) == CORPUS:
            raise ParameterError(f"{path} says itself what its points are", "give no table")
        seen = read_observations(path)
        return seen.names, np.where(seen.found[..., None], seen.points, np.nan)
    if unit is not None and unit not in UNITS:
        raise ParameterError(f"there is no unit '{unit}'", f"choose one of {', '.join(UNITS)}")
    try:
        names = tuple(map(str, arrays["names"]))
        points = np.asarray(arrays["points"], np.float64) * UNITS[unit or "mm"]
    except (KeyError, TypeError, ValueError) as error:
        raise ModelFormatError(
            f"{path} is neither {CORPUS} nor {OBSERVATIONS} nor points and their names",
            "give points (T, N, 3) and N names",
        ) from error
    if points.ndim != 3 or points.shape[1:] != (len(names), 3):
        raise InputFileError(
            f"{path} has {len(names)} names and points of shape {points.shape}",
            "give points (T, N, 3) and N names",
        )
    refuse_infinite(path, names, points)
    return names, points


def _check_mm(path: Path, unit: str | None) -> None:
    if unit not in (None, "mm"):
        raise ParameterError(f"{path} is in mm", "leave the unit out")


def _rate(path: Path, rate: float | None) -> float | None:
    """A corpus has no rate, so that a CSV of frames need not state one."""
    return 1.0 if rate is None and path.suffix.lower() != ".c3d" else rate


def _from_json(text: str) -> CorpusTable:
    told: dict[str, Any] = json.loads(text)
    groups = {str(g): tuple(map(str, names)) for g, names in told["groups"].items()}
    visemes = {str(v): _span(frames) for v, frames in told["visemes"].items()}
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
    if not visemes:
        raise ValueError("no visemes")
    if teeth and len(set(teeth) - {""}) != len(_TEETH):
        raise ValueError("upper_teeth are three points: right, left, front")
    return CorpusTable(groups, visemes, teeth)


def _assembled(
    path: Path, names: tuple[str, ...], points: FloatArray, table: CorpusTable
) -> Corpus:
    """The corpus of frames (T, N, 3)."""
    last = max(end for _, end in table.visemes.values())
    if last >= len(points):
        raise ParameterError(
            f"the table names frame {last}, {path} has {len(points)}", "count frames from 0"
        )
    if table.upper_teeth:
        used = sorted({f for a, b in table.visemes.values() for f in range(a, b + 1)})
        points = _on_bite_plane(names, points, table.upper_teeth, used)
    shown = [_mean(points[start : end + 1]) for start, end in table.visemes.values()]
    try:
        return Corpus(np.stack(shown), names, tuple(table.visemes), table.groups, source=path.name)
    except ParameterError as error:
        raise ParameterError(f"{path}: {error.problem}", error.remedy) from error


def _mean(points: FloatArray) -> FloatArray:
    """Mean (N, 3) over the frames (T, N, 3) in which a point is there; NaN where there is none."""
    there = np.asarray(np.isfinite(points).all(axis=2), np.bool_)
    count = there.sum(axis=0)[:, None]
    total = np.where(there[..., None], points, 0.0).sum(axis=0)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _on_bite_plane(
    names: tuple[str, ...], points: FloatArray, teeth: tuple[str, ...], used: list[int]
) -> FloatArray:
    """Points (T, N, 3) in the frame of the upper teeth, in the used frames."""
    lacking = [name for name in teeth if name not in names]
    if lacking:
        raise ParameterError(
            f"there is no point '{lacking[0]}' on the upper teeth",
            f"the points are {', '.join(names)}",
        )
    marks = [names.index(name) for name in teeth]
    out = np.full_like(points, np.nan)
    for frame in used:
        if not np.isfinite(points[frame, marks]).all():
            raise TooFewPointsError(
                f"a point of the upper teeth is missing in frame {frame}", "name another frame"
            )
        out[frame] = bite_plane(*points[frame, marks]).apply(points[frame])
    return out
