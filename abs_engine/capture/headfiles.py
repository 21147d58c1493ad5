"""Files about the head: its pose from elsewhere, and where points of the skull are in its frame."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from abs_engine.capture.headframe import HeadMotion
from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import InputFileError
from abs_engine.core.pose import POSE_NAMES
from abs_engine.io.csv_table import read_table

_REMEDY = "name the columns in line 1"


def read_head_poses(path: Path, frames: int) -> HeadMotion:
    """Read a CSV of the head's pose: columns frame, rx, ry, rz (radians), tx, ty, tz (mm).

    Rotation vector and translation take head points to the world (that of the first camera).
    Frames are counted from 0; empty cells: not known.

    Raises
    ------
    InputFileError
        If the file is missing, lacks a column or a frame, a value is no number, or a rotation is
        more than a full turn.
    """
    table = read_table(path, empty_lines=True, small=True)
    table.require(("frame", *POSE_NAMES), _REMEDY)
    out = np.full((frames, 6), np.nan)
    seen = np.zeros(frames, bool)
    for number, pose in zip(
        table.numbers(["frame"])[:, 0], table.numbers(POSE_NAMES, gaps=True), strict=True
    ):
        frame = int(np.nan_to_num(number, nan=-1.0))
        if 0 <= frame < frames:
            out[frame], seen[frame] = pose, True
    if not seen.all():
        raise InputFileError(
            f"{path} has no line for frame {int((~seen).argmax())}",
            f"give frames 0 to {frames - 1}",
        )
    out[~np.isfinite(out).all(axis=1)] = np.nan
    turns = np.linalg.norm(out[:, :3], axis=1)
    if np.any(turns > 2 * np.pi):
        frame = int((turns > 2 * np.pi).argmax())
        raise InputFileError(
            f"{path} turns the head by {turns[frame]:.0f} radians in frame {frame}, more than a "
            "full turn",
            "give rotation vectors in radians, not degrees",
        )
    return HeadMotion(out[:, :3], out[:, 3:], np.where(np.isnan(out[:, 0]), np.nan, 0.0))


def read_reference(path: Path) -> Mapping[str, FloatArray]:
    """Read where points are in the head frame, a CSV of point, x, y, z (mm).

    Raises
    ------
    InputFileError
        If the file is missing, lacks a column, or a value is no number.
    """
    table = read_table(path, small=True)
    table.require(("point", *"xyz"), _REMEDY)
    out = {}
    for name, place in zip(table.text("point"), table.numbers("xyz", gaps=True), strict=True):
        if not np.isfinite(place).all():
            raise InputFileError(f"{path} has no place for '{name}'", "give x, y and z")
        out[name] = place
    return out
