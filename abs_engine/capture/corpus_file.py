"""A user's own corpus: recorded points, and a table that says which are lips, jaw and teeth."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.capture.corpus import FORMAT as CORPUS
from abs_engine.capture.corpus import Corpus, bite_plane, load_corpus
from abs_engine.capture.corpus_table import HOW, CorpusTable, read_table
from abs_engine.capture.markers import UNITS, read_markers, refuse_infinite
from abs_engine.capture.observations import FORMAT as OBSERVATIONS
from abs_engine.capture.observations import read_observations
from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import (
    InputFileError,
    ModelFormatError,
    ParameterError,
    TooFewPointsError,
)
from abs_engine.core.kinds import to_path
from abs_engine.io.npz import format_of, read_arrays

SMALLEST = 15.0
"""mm that a face's points extend over at least: lips alone over 40, a face in metres over 0.3."""


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
        for what is in mm, the points are in metres, or two have one name.
    TooFewPointsError
        If a point of the upper teeth is missing in a frame that is used, or the three do not span
        a plane there.
    """
    path = to_path("path", path)
    if table is None:
        if path.suffix.lower() != ".npz" or _is_plain(read_arrays(path)):
            raise ParameterError(f"{path} does not say what its points are", f"give a table, {HOW}")
        _check_mm(path, unit)
        return load_corpus(path)
    told = read_table(table)
    if not told.visemes:
        raise InputFileError(f"{table} names no visemes", f"say which frames they are, {HOW}")
    names, points = _read_points(path, rate, unit)
    return _assembled(path, names, points, told)


def read_recording(
    path: Path, table: Path | None = None, unit: str | None = None
) -> tuple[tuple[str, ...], FloatArray]:
    """Read all frames of recorded points, in the frame that a corpus has.

    Parameters
    ----------
    path : Path
        C3D, CSV or NPZ, as for `read_corpus`, whose visemes are the frames.
    table : Path, optional
        Only its points of the upper teeth count; without them the points are in their frame.
    unit : {"mm", "cm", "m"}, optional

    Returns
    -------
    tuple of str, N
        Names of the points.
    (T, N, 3) float64, mm
        NaN where a point is missing, and in all of a frame where one of the upper teeth is, or
        where the three do not span a plane, as where a system writes zeros for what it lost.

    Raises
    ------
    InputFileError, ModelFormatError
        If a file is missing or cannot be read, or holds what is infinite.
    ParameterError
        If the table names points of the teeth that are not there, or two points have one name.
    TooFewPointsError
        If the upper teeth are seen, but in no frame span a plane.
    """
    path = Path(path)
    if table is None and path.suffix.lower() == ".npz" and format_of(read_arrays(path)) == CORPUS:
        corpus = read_corpus(path, unit=unit)
        return corpus.names, corpus.points
    teeth = () if table is None else read_table(table).upper_teeth
    names, points = _read_points(path, None, unit)
    if teeth:
        marks = _marks(names, teeth)
        whole = np.flatnonzero(np.isfinite(points[:, marks]).all(axis=(1, 2))).tolist()
        used = [frame for frame in whole if not _flat(points[frame], marks)]
        points = _on_bite_plane(points, marks, used or whole[:1])  # one error where all are flat
    return names, points


def _read_points(
    path: Path, rate: float | None, unit: str | None
) -> tuple[tuple[str, ...], FloatArray]:
    """Names, and points (T, N, 3), mm, of a file of any kind."""
    if path.suffix.lower() == ".npz":
        names, points = _read_npz(path, unit)
    else:
        markers = read_markers(path, _rate(path, rate), unit)
        names, points = markers.names, markers.points
    for name in names:
        if names.count(name) > 1:
            raise ParameterError(f"{path}: two points are named {name!r}", "name each once")
        if not name.isprintable():
            raise InputFileError(f"{path}: the name {name!r} cannot be printed", "change it")
    return names, points


def _is_plain(arrays: Mapping[str, NDArray[np.generic]]) -> bool:
    """Whether an archive holds points and their names, and does not say what they are."""
    return "format" not in arrays and {"names", "points"} <= set(arrays)


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
    if (
        not _is_plain(arrays)
        or (arrays["names"].ndim, arrays["names"].dtype.kind) != (1, "U")
        or arrays["points"].dtype.kind not in "iuf"
    ):
        raise ModelFormatError(
            f"{path} is neither {CORPUS} nor {OBSERVATIONS} nor points and their names",
            "give points (T, N, 3) as real numbers and N names as text",
        )
    names = tuple(map(str, arrays["names"]))
    points = np.asarray(arrays["points"], np.float64) * UNITS[unit or "mm"]
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
        marks = _marks(names, table.upper_teeth)
        lost = [frame for frame in used if not np.isfinite(points[frame, marks]).all()]
        if lost:
            raise TooFewPointsError(
                f"a point of the upper teeth is missing in frame {lost[0]}", "name another frame"
            )
        points = _on_bite_plane(points, marks, used)
    shown = [_mean(points[start : end + 1]) for start, end in table.visemes.values()]
    _check_size(path, np.stack(shown))
    try:
        return Corpus(np.stack(shown), names, tuple(table.visemes), table.groups, source=path.name)
    except ParameterError as error:
        raise ParameterError(f"{path}: {error.problem}", error.remedy) from error


def _check_size(path: Path, faces: FloatArray) -> None:
    """Refuse faces (V, N, 3) that are no larger than a tooth."""
    there = faces[np.isfinite(faces).all(axis=2)]
    size = float(np.linalg.norm(np.ptp(there, axis=0))) if len(there) else 0.0
    if 0 < size < SMALLEST:
        raise ParameterError(
            f"{path}: the faces measure {size:.2g} mm from end to end",
            "are they in mm? say so with --unit, such as --unit m",
        )


def _mean(points: FloatArray) -> FloatArray:
    """Mean (N, 3) over the frames (T, N, 3) in which a point is there; NaN where there is none."""
    there = np.asarray(np.isfinite(points).all(axis=2), np.bool_)
    count = there.sum(axis=0)[:, None]
    total = np.where(there[..., None], points, 0.0).sum(axis=0)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _marks(names: tuple[str, ...], teeth: tuple[str, ...]) -> list[int]:
    """Indices of the points on the upper teeth."""
    lacking = [name for name in teeth if name not in names]
    if lacking:
        raise ParameterError(
            f"there is no point '{lacking[0]}' on the upper teeth",
            f"the points are {', '.join(names)}",
        )
    return [names.index(name) for name in teeth]


def _on_bite_plane(points: FloatArray, marks: list[int], used: list[int]) -> FloatArray:
    """Points (T, N, 3) in the frame of the upper teeth; NaN in frames that are not used."""
    out = np.full_like(points, np.nan)
    for frame in used:
        try:
            out[frame] = bite_plane(*points[frame, marks]).apply(points[frame])
        except TooFewPointsError as error:
            raise TooFewPointsError(f"frame {frame}: {error.problem}", error.remedy) from error
    return out


def _flat(points: FloatArray, marks: list[int]) -> bool:
    """Whether the upper teeth of a frame (N, 3) span no plane."""
    try:
        bite_plane(*points[marks])
    except TooFewPointsError:
        return True
    return False
