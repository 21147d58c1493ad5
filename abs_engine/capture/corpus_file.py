"""A user's own corpus: recorded points, and a table that says which are lips, jaw and teeth."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.capture.corpus import FORMAT as CORPUS
from abs_engine.capture.corpus import Corpus, bite_plane, load_corpus
from abs_engine.capture.corpus_checks import check_exchanged, check_lips, check_unit, check_wild
from abs_engine.capture.corpus_table import HOW, CorpusTable, read_table
from abs_engine.capture.markers import read_markers
from abs_engine.capture.observations import FORMAT as OBSERVATIONS
from abs_engine.capture.observations import read_observations
from abs_engine.capture.recorded import (
    UNITS,
    RecordedPoints,
    check_size,
    refuse_infinite,
    without_zeros,
)
from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import (
    InputFileError,
    ModelFormatError,
    ParameterError,
    TooFewPointsError,
)
from abs_engine.core.kinds import to_path
from abs_engine.core.words import listed
from abs_engine.io.npz import format_of, read_arrays

_Say = Callable[[str], None] | None


def read_corpus(
    path: Path,
    table: Path | None = None,
    rate: float | None = None,
    unit: str | None = None,
    say: Callable[[str], None] | None = None,
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
    say : callable, optional
        Called with a line on positions at exactly 0, 0, 0, which count as missing.

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
        for what is in mm, the points are in metres or centimetres, or two have one name; or if
        the groups ``upper_lip`` and ``lower_lip`` do not lie as lips do.
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
    return _assembled(path, _read_points(path, rate, unit, say), told)


def read_recording(
    path: Path,
    table: Path | None = None,
    unit: str | None = None,
    say: Callable[[str], None] | None = None,
) -> RecordedPoints:
    """Read all frames of recorded points, in the frame that a corpus has.

    Parameters
    ----------
    path : Path
        C3D, CSV or NPZ, as for `read_corpus`, whose visemes are the frames.
    table : Path, optional
        Only its points of the upper teeth count; without them the points are in their frame.
    unit : {"mm", "cm", "m"}, optional
    say : callable, optional
        See `read_corpus`.

    Returns
    -------
    RecordedPoints
        With NaN in all of a frame where one of the upper teeth is missing, or where the three do
        not span a plane.

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
        return RecordedPoints(corpus.names, corpus.points)
    teeth = () if table is None else read_table(table).upper_teeth
    recording = _read_points(path, None, unit, say)
    if not teeth:
        return recording
    points, marks = recording.points, _marks(recording.names, teeth)
    whole = np.flatnonzero(np.isfinite(points[:, marks]).all(axis=(1, 2))).tolist()
    used = [frame for frame in whole if not _flat(points[frame], marks)]
    return _on_bite_plane(recording, marks, used or whole[:1])  # one error where all are flat


def _read_points(path: Path, rate: float | None, unit: str | None, say: _Say) -> RecordedPoints:
    """Points of a file of any kind."""
    if path.suffix.lower() == ".npz":
        recording = _read_npz(path, unit, say)
    else:
        markers = read_markers(path, rate, unit, say, timed=False)
        recording = RecordedPoints(markers.names, markers.points, markers.first)
    for name in recording.names:
        if recording.names.count(name) > 1:
            raise ParameterError(f"{path}: two points are named {name!r}", "name each once")
        if not name.isprintable():
            raise InputFileError(f"{path}: the name {name!r} cannot be printed", "change it")
    return recording


def _is_plain(arrays: Mapping[str, NDArray[np.generic]]) -> bool:
    """Whether an archive holds points and their names, and does not say what they are."""
    return "format" not in arrays and {"names", "points"} <= set(arrays)


def _read_npz(path: Path, unit: str | None, say: _Say) -> RecordedPoints:
    """Points of observations, or of an archive that holds just these and their names."""
    arrays = read_arrays(path)
    if "format" in arrays:
        _check_mm(path, unit)
        if format_of(arrays) == CORPUS:
            raise ParameterError(f"{path} says itself what its points are", "give no table")
        seen = read_observations(path)
        points = np.where(seen.found[..., None], seen.points, np.nan)
        return RecordedPoints(seen.names, points, seen.first)
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
    return RecordedPoints(names, without_zeros(points, say))


def _check_mm(path: Path, unit: str | None) -> None:
    if unit not in (None, "mm"):
        raise ParameterError(f"{path} is in mm", "leave the unit out")


def _assembled(path: Path, recording: RecordedPoints, table: CorpusTable) -> Corpus:
    """The corpus of a recording's frames."""
    first, count = recording.first, len(recording.points)
    spans = {name: (a - first, b - first) for name, (a, b) in table.visemes.items()}
    for name, (start, end) in spans.items():
        if start < 0 or end >= count:
            raise ParameterError(
                f"the table names frame {first + (start if start < 0 else end)} for '{name}', "
                f"{path} has {recording.numbers}",
                "use the numbers of its column frame, or count from 0 if it has none",
            )
    names = recording.names
    used = sorted({f for a, b in spans.values() for f in range(a, b + 1)})
    if table.upper_teeth:
        marks = _marks(names, table.upper_teeth)
        lost = [f for f in used if not np.isfinite(recording.points[f, marks]).all()]
        if lost:
            raise TooFewPointsError(
                f"a point of the upper teeth is missing in frame {first + lost[0]}",
                "name another frame",
            )
        recording = _on_bite_plane(recording, marks, used)
    shown = np.stack([_mean(recording.points[start : end + 1]) for start, end in spans.values()])
    try:
        named = {name for group in table.groups.values() for name in group}
        at = [k for k, name in enumerate(names) if name in named]
        points, own, frames = (
            recording.points[used][:, at],
            [names[k] for k in at],
            [first + f for f in used],
        )
        check_unit(points)
        check_wild(points, own, frames)
        check_exchanged(points, own, frames)
        check_size(shown)
        made = Corpus(shown, names, tuple(spans), table.groups, source=path.name)
        check_lips(made)
    except ParameterError as error:
        raise ParameterError(f"{path}: {error.problem}", error.remedy) from error
    return made


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
            f"the points are {listed(names)}",
        )
    return [names.index(name) for name in teeth]


def _on_bite_plane(recording: RecordedPoints, marks: list[int], used: list[int]) -> RecordedPoints:
    """Points in the frame of the upper teeth; NaN in frames (from 0) that are not used."""
    points, out = recording.points, np.full_like(recording.points, np.nan)
    for frame in used:
        try:
            out[frame] = bite_plane(*points[frame, marks]).apply(points[frame])
        except TooFewPointsError as error:
            where = f"frame {recording.first + frame}"
            raise TooFewPointsError(f"{where}: {error.problem}", error.remedy) from error
    return replace(recording, points=out)


def _flat(points: FloatArray, marks: list[int]) -> bool:
    """Whether the upper teeth of a frame (N, 3) span no plane."""
    try:
        bite_plane(*points[marks])
    except TooFewPointsError:
        return True
    return False
