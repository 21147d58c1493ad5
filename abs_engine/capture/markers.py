"""Marker files of other systems, C3D and CSV, read into points."""

from __future__ import annotations

import struct
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import BinaryIO

import c3d
import numpy as np

from abs_engine.capture.marker_table import read_cells
from abs_engine.capture.recorded import UNITS, refuse_infinite, without_zeros
from abs_engine.capture.settings import CAPTURE
from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.core.words import listed
from abs_engine.io.inputs import MOST, check_file

_BROKEN = (ValueError, KeyError, IndexError, AttributeError, TypeError, AssertionError,
           EOFError, ArithmeticError, NameError, MemoryError, struct.error, OSError)  # fmt: skip
"""What the C3D library raises on files that are none, or are cut."""

_RATE_OFF = 0.02
"""Share by which a rate may differ from that of a CSV's times, which may be rounded. Chosen."""
_SLOWEST = 1.0
"""Seconds between frames at most. Chosen: milliseconds make 3 and more of usual rates."""


@dataclass(frozen=True, eq=False)
class Markers:
    """Markers as recorded.

    Parameters
    ----------
    names : tuple of str, N
    points : (T, N, 3) float64, mm, the recording system's frame
        NaN where a marker is missing.
    residual : (T, N) float64, mm
        As the file states it; 0 in a CSV.
    rate : float
        Frames per second.
    first : int
        Number of the first frame by the column ``frame`` of a CSV; else 0.
    """

    names: tuple[str, ...]
    points: FloatArray
    residual: FloatArray
    rate: float
    first: int = 0

    def renamed(self, names: Mapping[str, str]) -> Markers:
        """The same with other names for some.

        Raises
        ------
        ParameterError
            If a marker is not there, or two come to have one name.
        """
        lacking = [name for name in names if name not in self.names]
        if lacking:
            raise ParameterError(
                f"there is no marker '{lacking[0]}'", f"the markers are {listed(self.names)}"
            )
        new = tuple(names.get(name, name) for name in self.names)
        _check_unique(new)
        return replace(self, names=new)


def read_markers(
    path: Path,
    rate: float | None = None,
    unit: str | None = None,
    say: Callable[[str], None] | None = None,
    *,
    timed: bool = True,
) -> Markers:
    """Read a marker file, C3D by its suffix, else CSV.

    A CSV has a column ``frame`` and/or ``time`` (seconds), and ``NAME_x``, ``NAME_y``, ``NAME_z``
    for each marker; or a line for each marker with ``point``, ``x``, ``y``, ``z``. Empty cells: the
    marker is missing, as it is where it lies at exactly 0, 0, 0; see `without_zeros`.

    Parameters
    ----------
    rate : float, optional
        Frames per second, where the file does not say.
    unit : {"mm", "cm", "m"}, optional
        Where the file does not say; mm by default.
    say : callable, optional
        Called with a line that counts the zeros.
    timed : bool
        Whether the rate matters. If not, a CSV need not state it, and its times are not looked at.

    Raises
    ------
    InputFileError
        If the file is missing, cut or of another kind, holds no marker or what is infinite, has
        fewer labels than points, or its rate is not known or less than a frame a second.
    ParameterError
        If the unit is unknown, the rate is not above 0, or the file states another unit or rate.
    """
    path = Path(path)
    if unit is not None and unit not in UNITS:
        raise ParameterError(f"there is no unit '{unit}'", f"choose one of {', '.join(UNITS)}")
    if rate is not None and not 0 < rate <= MOST:
        raise ParameterError(f"{rate:g} is not a rate above 0", "give frames per second")
    check_file(path)
    if path.suffix.lower() == ".c3d":
        markers = _read_c3d(path, rate, unit)
    else:
        markers = _read_csv(path, rate, unit, timed)
    if not markers.names or not len(markers.points):
        raise InputFileError(f"{path} holds no markers", "check the file")
    whole = np.dstack([markers.points, markers.residual])
    refuse_infinite(path, markers.names, whole, markers.first)
    points = without_zeros(markers.points, say)
    residual = np.where(np.isnan(points[..., 0]), np.nan, markers.residual)
    return replace(markers, points=points, residual=residual)


def _read_c3d(path: Path, rate: float | None, unit: str | None) -> Markers:
    try:
        with path.open("rb") as file, warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that there are no analogue channels
            names, frames, told_rate, told_unit, expected = _c3d_parts(file)
    except _BROKEN as error:
        raise InputFileError(
            f"{path} is not a C3D file that can be read", "export it again"
        ) from error
    if len(frames) != expected:
        raise InputFileError(
            f"{path} is cut off after {len(frames)} of {expected} frames", "export it again"
        )
    for given, told, said in (
        (rate and np.float32(rate), told_rate, f"rate {told_rate:.7g}"),  # rounded as in the file
        (unit, told_unit, f"unit {told_unit}"),
    ):
        if given is not None and told and given != told:
            raise ParameterError(f"{path} states the {said}", "leave the option out")
    used = told_unit or unit or "mm"
    if used not in UNITS:
        raise InputFileError(f"{path} is in '{used}'", f"export it in {', '.join(UNITS)}")
    values = np.stack(frames) if frames else np.zeros((0, 0, 5))
    if len(names) < values.shape[1]:
        raise InputFileError(
            f"{path} has {values.shape[1]} points and {len(names)} labels",
            "export it with a label for each point",
        )
    points, residual = values[..., :3] * UNITS[used], values[..., 3] * UNITS[used]
    missing = values[..., 3] < 0
    points[missing], residual[missing] = np.nan, np.nan
    return Markers(names, points, residual, _rate(path, told_rate or rate))


def _c3d_parts(file: BinaryIO) -> tuple[tuple[str, ...], list[FloatArray], float, str, int]:
    """Names, frames (N, 5), rate, unit (empty where it is not stated), number of frames."""
    reader = c3d.Reader(file)
    if reader.analog_used and not reader.point_used:
        raise InputFileError(
            f"{file.name} holds no points, only analog channels", "export the markers, too"
        )
    names = _labels(reader)[: reader.point_used]
    _check_unique(names)
    stated = reader.get("POINT.UNITS")
    unit = "" if stated is None else stated.string_value.strip().strip("\0").lower()
    frames = [np.array(p, np.float64) for _, p, _ in reader.read_frames(copy=True)]
    return names, frames, float(reader.point_rate), unit, int(reader.frame_count)


def _labels(reader: c3d.Reader) -> tuple[str, ...]:
    """Labels of all points: those above 255 go on in LABELS2, LABELS3 and so on."""
    labels, more = list(reader.point_labels), 2
    while (further := reader.get(f"POINT.LABELS{more}")) is not None:
        labels += list(further.string_array)
        more += 1
    return tuple(str(label).strip() for label in labels)


def _read_csv(path: Path, rate: float | None, unit: str | None, timed: bool) -> Markers:
    header, table = read_cells(path)
    scale = UNITS[unit or "mm"]
    frame = table[:, header.index("frame")] if "frame" in header else None
    time = table[:, header.index("time")] if "time" in header else None
    names = tuple(n[:-2] for n in header if n.endswith("_x"))
    _check_unique(names)
    lacking = [f"{n}_{c}" for n in names for c in "xyz" if f"{n}_{c}" not in header]
    if lacking or not names or (frame is None and time is None):
        raise InputFileError(
            f"{path} has no column {lacking[0] if lacking else 'frame, time or NAME_x'}",
            "give frame or time, and NAME_x, NAME_y, NAME_z for each marker",
        )
    columns = [[header.index(f"{n}_{c}") for c in "xyz"] for n in names]
    points = table[:, columns] * scale
    points[np.isnan(points).any(axis=2)] = np.nan
    first = 0.0 if frame is None else float(frame[0])
    if frame is not None:
        _check_order(path, frame)
    if not first.is_integer():
        raise InputFileError(f"{path}: '{first:g}' is not a frame number", "use whole numbers")
    told = _stated_rate(path, time, rate) if timed else rate or 1.0
    rate = _rate(path, rate or told)
    return Markers(names, points, np.zeros(points.shape[:2]), rate, int(first))


def _stated_rate(path: Path, time: FloatArray | None, given: float | None) -> float | None:
    """The rate by a column of times; one that is given must not contradict it.

    Uneven times state none where a rate is given.
    """
    try:
        told = _rate_of(path, time)
    except InputFileError:
        if given:
            return None
        raise
    if given and told and abs(given - told) > _RATE_OFF * told:
        raise ParameterError(
            f"{path} states the rate {told:.6g} by its column time", "leave the option out"
        )
    return told


def _check_order(path: Path, frames: FloatArray) -> None:
    """Refuse frame numbers (T,) that do not follow each other; says where."""
    wrong = np.flatnonzero(np.diff(frames) != 1)
    if not len(wrong):
        return
    where = f"frame {frames[wrong[0] + 1]:.12g} comes after frame {frames[wrong[0]]:.12g}"
    if (np.diff(np.sort(frames)) == 1).all():
        raise InputFileError(f"the lines of {path} are not in order: {where}", "sort them")
    raise InputFileError(
        f"{path} skips or repeats a frame: {where}", "give one line for every frame, in order"
    )


def _rate_of(path: Path, time: FloatArray | None) -> float:
    """Frames per second by times (T,); 0 where there are none."""
    if time is None or len(time) < 2 or np.isnan(time).all():
        return 0.0
    steps = np.diff(time)
    usual = float(np.median(steps))
    if not np.isfinite(time).all() or not usual > 0 or steps.min() < usual / CAPTURE.uneven \
            or steps.max() > CAPTURE.uneven * usual:  # fmt: skip
        raise InputFileError(f"{path} is not evenly spaced in time", "give a line for every frame")
    if usual > _SLOWEST:
        raise InputFileError(
            f"frames of {path} are {usual:g} s apart by its column time",
            "give seconds there, not milliseconds",
        )
    return float((len(time) - 1) / (time[-1] - time[0]))


def _rate(path: Path, rate: float | None) -> float:
    if not rate or not 0 < rate <= MOST:
        raise InputFileError(f"{path} does not state its frame rate", "give --rate")
    return rate


def _check_unique(names: tuple[str, ...]) -> None:
    twice = sorted({n for n in names if names.count(n) > 1})
    if twice:
        raise ParameterError(f"two markers are named '{twice[0]}'", "give each its own name")
