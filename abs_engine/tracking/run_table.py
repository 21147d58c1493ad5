"""The tables of a run for spreadsheets: a row for each frame, and one for each closure."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.pose import POSE_NAMES
from abs_engine.io.assets import CLOSED_APERTURE, LIPS_OF_68
from abs_engine.tracking.clip_setting import ClipSetting
from abs_engine.tracking.frame_rows import BELIEVED, LANDMARK_MEASURES
from abs_engine.tracking.measures import NAMES, Closure

POINT_NAMES = tuple(f"lip{k}" for k in range(68)[LIPS_OF_68])
"""The 20 lip points by their numbers among the usual 68: 12 outer, then 8 inner."""

_PLACE = ("rotation", "translation", "parameters", "points")
_REST = (
    "width", "aperture", "closed", "value", "score", "evaluations", "covered", *LANDMARK_MEASURES,
    "protrusion", *(f"{name}_sd" for name in BELIEVED), "closed_probability", "contradicted",
    *NAMES, "status",
)  # fmt: skip


def table_of(
    setting: ClipSetting, arrays: Mapping[str, NDArray[Any]], points: FloatArray
) -> Iterator[list[Any]]:
    """The table of all frames, its heading first.

    Parameters
    ----------
    setting : ClipSetting
    arrays : mapping of str to (T, ...)
        As ``results.npz`` has them.
    points : (T, 20, 3) float64, mm, head frame

    Yields
    ------
    list
        A row.
    """
    yield heading(setting)
    found = arrays["found"]
    of_lips = {name: np.where(found, arrays[name], np.nan) for name in ("closed", "contradicted")}
    every = {**arrays, "points": points, **of_lips}
    columns = [_plain(every[name]) for name in ("index", "time", "found", *_PLACE, *_REST)]
    for row in zip(*columns, strict=True):
        yield [cell for values in row for cell in values.tolist()]


def _plain(column: NDArray[Any]) -> NDArray[Any]:
    """A column (T, ...) as (T, K), truths as 0 and 1."""
    flat = column.reshape(len(column), math.prod(column.shape[1:]))
    return flat.astype(np.int8) if column.dtype == np.bool_ else flat


def heading(setting: ClipSetting) -> list[str]:
    """Column names of ``results.csv``."""
    points = [f"{name}_{axis}" for name in POINT_NAMES for axis in "xyz"]
    pose = [f"head_{name}" for name in POSE_NAMES]
    return ["index", "time", "found", *pose, *setting.face.blocks.spec.names, *points, *_REST]


def closure_table(found: Iterable[Closure]) -> list[list[Any]]:
    """The table of ``closures.csv``, its heading first."""
    names = ["onset", "release", "duration", "first_frame", "last_frame", "least_aperture"]
    rows = [[c.onset, c.release, c.release - c.onset, c.first, c.last, c.least] for c in found]
    return [list(names), *rows]


def cells(row: Iterable[Any]) -> list[Any]:
    """A row as it is written: numbers short enough to read, empty where they are NaN."""
    return [_cell(value) for value in row]


def _cell(value: Any) -> Any:
    if isinstance(value, float):  # NumPy's float64 is one
        return "" if np.isnan(value) else f"{value:.6g}"
    return value


def closed_frames(aperture: Any) -> NDArray[np.bool_]:
    """Whether lips of an aperture in mm count as closed; never where it is NaN."""
    return np.asarray(np.asarray(aperture) < CLOSED_APERTURE)
