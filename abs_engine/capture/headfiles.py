"""Files about the head: its pose from elsewhere, and where points of the skull are in its frame."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from abs_engine.capture.headframe import HeadMotion
from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import InputFileError
from abs_engine.io.inputs import check_file, to_number


def read_head_poses(path: Path, frames: int) -> HeadMotion:
    """Read a CSV of the head's pose: columns frame, rx, ry, rz (radians), tx, ty, tz (mm).

    Rotation vector and translation take head points to the world (that of the first camera).
    Frames are counted from 0; empty cells: not known.

    Raises
    ------
    InputFileError
        If the file is missing, lacks a column or a frame, or a value is no number.
    """
    names = ("rx", "ry", "rz", "tx", "ty", "tz")
    rows = _table(path, ("frame", *names))
    out = np.full((frames, 6), np.nan)
    seen = np.zeros(frames, bool)
    for row in rows:
        frame = int(np.nan_to_num(row["frame"], nan=-1.0))
        if 0 <= frame < frames:
            out[frame], seen[frame] = [row[n] for n in names], True
    if not seen.all():
        raise InputFileError(
            f"{path} has no line for frame {int((~seen).argmax())}",
            f"give frames 0 to {frames - 1}",
        )
    out[~np.isfinite(out).all(axis=1)] = np.nan
    return HeadMotion(out[:, :3], out[:, 3:], np.where(np.isnan(out[:, 0]), np.nan, 0.0))


def read_reference(path: Path) -> Mapping[str, FloatArray]:
    """Read where points are in the head frame, a CSV of point, x, y, z (mm).

    Raises
    ------
    InputFileError
        If the file is missing, lacks a column, or a value is no number.
    """
    out = {}
    for row in _table(path, ("x", "y", "z"), text="point"):
        place = np.array([row[k] for k in "xyz"])
        if not np.isfinite(place).all():
            raise InputFileError(f"{path} has no place for '{row['point']}'", "give x, y and z")
        out[str(row["point"])] = place
    return out


def _table(path: Path, numbers: Sequence[str], text: str | None = None) -> list[dict[str, Any]]:
    check_file(path)
    try:
        lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputFileError(f"{path} cannot be read as text", "check the path") from error
    reader = csv.DictReader(lines, skipinitialspace=True)
    lacking = {*numbers, *([text] if text else [])} - set(reader.fieldnames or [])
    if lacking:
        raise InputFileError(
            f"{path} has no column {', '.join(sorted(lacking))}", "name the columns in line 1"
        )
    out: list[dict[str, Any]] = []
    for row in reader:
        try:
            told: dict[str, Any] = {n: to_number(row[n] or "", gaps=True) for n in numbers}
        except ValueError as error:
            raise InputFileError(
                f"{path}, line {reader.line_num}: {error}", "give numbers"
            ) from error
        out.append(told | ({text: str(row[text]).strip()} if text else {}))
    return out
