"""A recorded stream of ARKit face units, as the Live Link Face app writes it."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.dataset.head_angles import rotation_by
from abs_engine.dataset.timecode import seconds
from abs_engine.io.inputs import read_text, to_number
from abs_engine.studio.speech.articulate import Speech, check_rate

MOST_FRAMES = 1_000_000
"""Of a recording that is played: nine hours at 30 frames a second."""
_EARLY = 0.25
"""Share of a frame by which the last sample may be early: cameras' times waver. Chosen."""
_LATE = 1.0
"""Seconds after timecode 0 from which on a clock was running before the recording. Chosen."""
_HEAD = ("HeadYaw", "HeadPitch", "HeadRoll")


@dataclass(frozen=True, eq=False)
class Recording:
    """Face units as recorded, N samples.

    Parameters
    ----------
    unit_names : tuple of str
        As in ARKit, such as 'jawOpen'.
    weights : (N, 52) float64
    head : (N, 3) float64
        Yaw, pitch and roll, radians.
    times : (N,) float64
        Seconds, growing: since the first sample; or since timecode 0 where the first sample comes
        less than a second after it, as where the first rows of an export are missing.
    """

    unit_names: tuple[str, ...]
    weights: FloatArray
    head: FloatArray
    times: FloatArray


def read_livelink(path: Path | str) -> Recording:
    """Read a Live Link Face CSV.

    Returns
    -------
    Recording
        The eyes' own angles are left out; ARKit has them among the units as well. Lost frames,
        whose cells are empty, take what lies between the frames about them.

    Raises
    ------
    InputFileError
        If the file is missing, has no timecode, units or samples, a line has another number of
        values than the header, a value is no number, all frames are lost, or time does not
        grow.
    """
    path = Path(path)
    header, rows, lines = _rows(path)
    angles = ("Yaw", "Pitch", "Roll")
    columns = [i for i, name in enumerate(header) if i > 1 and not name.endswith(angles)]
    names = tuple(header[i][0].lower() + header[i][1:] for i in columns)
    times = _seconds(path, [row[0] for row in rows], lines)
    values = _bridged(path, times, _numbers(path, header, rows, lines))
    places = [header.index(name) - 2 if name in header else -1 for name in _HEAD]
    head = np.stack([values[:, i] if i >= 0 else np.zeros(len(values)) for i in places], axis=1)
    return Recording(names, values[:, np.array(columns) - 2], head, times)


def play_recording(recording: Recording, unit_names: tuple[str, ...], rate: float) -> Speech:
    """Face-unit weights of a recording at a frame rate.

    Parameters
    ----------
    unit_names : tuple of str
        Order of the weights that is wanted.
    rate : float
        Frames per second. Samples are joined by straight lines, weights kept within 0 and 1.

    Returns
    -------
    Speech
        Its `head` is the rotation about the head frame's axes, see `head_angles`.

    Raises
    ------
    ParameterError
        If the recording lacks a unit, lasts too long, or the rate is not positive.
    """
    known = {name.lower(): i for i, name in enumerate(recording.unit_names)}
    lacking = [name for name in unit_names if name.lower() not in known]
    if lacking:
        raise ParameterError(
            f"the recording has no '{lacking[0]}'", "record all 52 ARKit face units"
        )
    check_rate(rate)
    if recording.times[-1] * rate > MOST_FRAMES:
        raise ParameterError(
            f"the recording lasts {recording.times[-1] / 3600:.1f} h, more than {MOST_FRAMES} "
            f"frames at {rate:g} a second",
            "correct its timecodes, or cut it",
        )
    times = np.arange(int(recording.times[-1] * rate + _EARLY) + 1) / rate
    picked = recording.weights[:, [known[name.lower()] for name in unit_names]]
    weights = np.stack([np.interp(times, recording.times, c) for c in picked.T], axis=1)
    angles = np.unwrap(recording.head, axis=0)
    turned = np.stack([np.interp(times, recording.times, c) for c in angles.T], axis=1)
    head = rotation_by(turned).as_rotvec()
    labels = ("_",) * len(times)
    return Speech(np.clip(weights, 0.0, 1.0), labels, (), rate, np.asarray(head, np.float64))


def _rows(path: Path) -> tuple[list[str], list[list[str]], list[int]]:
    """Header, samples, and the line number of each."""
    text = read_text(path, "give a Live Link Face CSV")
    try:
        lines = list(csv.reader(text.splitlines()))
    except csv.Error as error:
        raise InputFileError(f"{path} is not a CSV file", "give a Live Link Face CSV") from error
    header = [name.strip() for name in lines[0]] if lines else []
    if [name.lower() for name in header[:2]] != ["timecode", "blendshapecount"]:
        raise InputFileError(
            f"{path} does not begin with Timecode and BlendShapeCount", "give a Live Link Face CSV"
        )
    numbers = [number for number, row in enumerate(lines, 1) if number > 1 and row]
    rows = [lines[number - 1] for number in numbers]
    if not rows or len(header) < 3 or "" in header:
        raise InputFileError(f"{path} holds no samples, or a column no name", "record it again")
    return header, rows, numbers


def _numbers(path: Path, header: list[str], rows: list[list[str]], lines: list[int]) -> FloatArray:
    """Values (N, C - 2) behind timecode and count; NaN where all are empty: the frame was lost."""
    values = np.empty((len(rows), len(header) - 2))
    for k, (line, row) in enumerate(zip(lines, rows, strict=True)):
        if len(row) != len(header):
            raise InputFileError(
                f"line {line} of {path} has {len(row)} values, its header {len(header)}",
                "check that the file is whole",
            )
        if not any(cell.strip() for cell in row[2:]):
            values[k] = np.nan
            continue
        try:
            values[k] = [to_number(cell) for cell in row[2:]]
        except ValueError as error:
            raise InputFileError(
                f"line {line} of {path}: {error}", "correct it, or leave that line out"
            ) from error
    return values


def _bridged(path: Path, times: FloatArray, values: FloatArray) -> FloatArray:
    """Values (N, D) with those of lost frames on straight lines between the frames about them."""
    known = ~np.isnan(values).any(axis=1)
    if not known.any():
        raise InputFileError(f"every frame of {path} is lost", "give a recording with a face")
    columns = [np.interp(times, times[known], column[known]) for column in values.T]
    return np.stack(columns, axis=1)


def _seconds(path: Path, codes: list[str], lines: list[int]) -> FloatArray:
    """Growing seconds since the first timecode, or since 0, if it is less than a second later."""
    times = seconds(codes, path, lines=lines)
    if times[0] >= _LATE:
        times -= times[0]
    steps = np.diff(times)
    if (steps <= 0).any():
        line = lines[1 + int(np.flatnonzero(steps <= 0)[0])]
        raise InputFileError(
            f"line {line} of {path} is not later than the line before it",
            "sort the lines",
        )
    return times
