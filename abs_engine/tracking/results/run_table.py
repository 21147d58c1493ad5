"""The tables of a run for spreadsheets: a row for each frame, and one for each closure."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.pose import POSE_NAMES
from abs_engine.io.assets import CLOSED_APERTURE, LIPS_OF_68
from abs_engine.tracking.results.frame_rows import BELIEVED, LANDMARK_MEASURES
from abs_engine.tracking.results.measures import NAMES, Closure

POINT_NAMES = tuple(f"lip{k}" for k in range(68)[LIPS_OF_68])
"""The 20 lip points by their numbers among the usual 68: 12 outer, then 8 inner."""

LESS = "less_explained"
_FIRST = ("index", "time", "found")
_REST = (
    "width", "aperture", "closed", "value", "score", "evaluations", "covered", *LANDMARK_MEASURES,
    "protrusion", *(f"{name}_sd" for name in BELIEVED), "closed_probability", "contradicted",
    LESS, *NAMES, "status",
)  # fmt: skip
OF_LIPS = ("closed", "contradicted", LESS)
"""Columns that are neither true nor false where the lips were not found."""
_TIMES = {"time", "onset", "release"}
_BLOCK = 1000  # rows that are made of columns at once


def columns_of(arrays: Mapping[str, NDArray[Any]], points: FloatArray) -> dict[str, NDArray[Any]]:
    """The columns of ``results.csv``, (T,) each, by their names.

    Those of `OF_LIPS` are masked where the lips were not found. The arrays, (T, ...) each, are as
    ``results.npz`` has them; measures that an older run lacks are left out. Points are (T, 20, 3)
    float64, mm, head frame.
    """
    names = [
        *(f"head_{name}" for name in POSE_NAMES),
        *map(str, arrays["parameter_names"]),
        *(f"{name}_{axis}" for name in POINT_NAMES for axis in "xyz"),
    ]
    places = points.reshape(len(points), 3 * len(POINT_NAMES))
    numbers = (arrays["rotation"], arrays["translation"], arrays["parameters"], places)
    moved = zip(names, (column for one in numbers for column in one.T), strict=True)
    first, rest = ({k: arrays[k] for k in part if k in arrays} for part in (_FIRST, _REST))
    lost = ~arrays["found"]
    seen = {k: np.ma.masked_array(rest[k], lost) for k in OF_LIPS if k in rest}
    return {**first, **dict(moved), **rest, **seen}


def table_of(arrays: Mapping[str, NDArray[Any]], points: FloatArray) -> Iterator[list[Any]]:
    """Rows of the table of all frames, its heading first, booleans as 0 and 1; see `columns_of`."""
    columns = columns_of(arrays, points)
    yield list(columns)
    plain = [v.astype(np.int8) if v.dtype == np.bool_ else v for v in columns.values()]
    for first in range(0, len(points), _BLOCK):
        part = (column[first : first + _BLOCK].tolist() for column in plain)
        yield from map(list, zip(*part, strict=True))


def closure_table(found: Iterable[Closure]) -> list[list[Any]]:
    """The table of ``closures.csv``, its heading first."""
    names = ["onset", "release", "duration", "first_frame", "last_frame", "least_aperture"]
    rows = [[c.onset, c.release, c.release - c.onset, c.first, c.last, c.least] for c in found]
    return [list(names), *rows]


def written(table: Iterable[Sequence[Any]]) -> Iterator[list[Any]]:
    """Rows of a table, its heading first, as they are written: numbers short enough to read.

    Times have the same decimals however long the clip is; cells are empty where numbers are NaN or
    None.
    """
    rows = iter(table)
    names = list(next(rows))
    yield names
    for row in rows:
        yield [_cell(name, value) for name, value in zip(names, row, strict=True)]


def _cell(name: str, value: Any) -> Any:
    if not isinstance(value, float):  # NumPy's float64 is one
        return value
    if np.isnan(value):
        return ""
    return time_cell(value) if name in _TIMES else f"{value:.6g}"


def time_cell(seconds: float) -> str:
    """A time as tables have it, in seconds, to a microsecond."""
    return f"{seconds:.6f}"


def sure_frames(run: Mapping[str, NDArray[Any]]) -> BoolArray:
    """Frames (T,) whose mouth was found and seen, and that nothing throws doubt on.

    Neither the landmarks, nor, where the run knows of it, how much of the other frames is
    explained.
    """
    doubtful = run["covered"] | run["contradicted"] | run.get(LESS, False)
    return np.asarray(run["found"] & ~doubtful)


def closed_frames(aperture: Any) -> NDArray[np.bool_]:
    """Whether lips of an aperture in mm count as closed; never where it is NaN."""
    return np.asarray(np.asarray(aperture) < CLOSED_APERTURE)
