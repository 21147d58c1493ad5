"""Recorded points of any file, their checks, and the marks of lost ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from abs_engine.capture.settings import CAPTURE
from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.core.words import counted
from abs_engine.io.inputs import MOST

UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0}
"""Millimetres of each unit."""


@dataclass(frozen=True, eq=False)
class RecordedPoints:
    """Points of all frames of a file.

    Parameters
    ----------
    names : tuple of str, N
    points : (T, N, 3) float64, mm
        NaN where a point is missing.
    first : int
        Number of the first frame, as the file counts them.
    """

    names: tuple[str, ...]
    points: FloatArray
    first: int = 0

    @property
    def numbers(self) -> str:
        """The numbers of its frames, as messages name them."""
        return f"frames {self.first} to {self.first + len(self.points) - 1}"


def refuse_infinite(path: Path, names: Sequence[str], points: FloatArray, first: int = 0) -> None:
    """Raise `InputFileError` if a point (T, N, 3) is infinite, which is not to pass for a gap.

    `first` is the number of the first frame.
    """
    frames, which = np.nonzero((np.abs(points) > MOST).any(axis=2))
    if len(frames):
        raise InputFileError(
            f"{path}: '{names[which[0]]}' is out of all bounds in frame {first + frames[0]}",
            "leave its place empty where a point is missing",
        )


def check_size(points: FloatArray, remedy: str = "") -> None:
    """Raise `ParameterError` if a face's points (T, N, 3), mm, extend too little in every frame.

    Points in cm or m do, if the file does not state the unit; `remedy` says what to do instead.
    """
    there = np.asarray(np.isfinite(points).all(axis=2), np.bool_)
    low, high = (
        end(np.where(there[..., None], points, far), axis=1)
        for end, far in ((np.min, np.inf), (np.max, -np.inf))
    )
    size = np.linalg.norm(high - low, axis=1)[there.any(axis=1)].max(initial=0.0)
    if 0 < size < CAPTURE.smallest:
        raise ParameterError(
            f"the points of the face measure {size:.2g} mm from end to end",
            remedy
            or f"are they in mm? say so with --unit, such as --unit {'cm' if size > 1 else 'm'}",
        )


def without_zeros(points: FloatArray, say: Callable[[str], None] | None = None) -> FloatArray:
    """Points (T, N, 3) with NaN for those at exactly 0, 0, 0, as many systems write lost points.

    A single point that lies there throughout is the origin of its frame. `say` is called with a
    line that counts the others.
    """
    lost = np.asarray((points == 0).all(axis=2), np.bool_)
    gaps = np.asarray(np.isnan(points).any(axis=2), np.bool_)
    throughout = (lost | gaps).all(axis=0) & lost.any(axis=0)
    if throughout.sum() == 1:
        lost[:, throughout] = False
    if say is not None and lost.any():
        say(f"{counted(int(lost.sum()), 'position')} at exactly 0, 0, 0 treated as missing")
    return np.where(lost[..., None], np.nan, points)


def refuse_turn(where: str, vector: FloatArray) -> None:
    """Raise `InputFileError` if a head's rotation vector (3,) is more than a full turn."""
    turn = float(np.linalg.norm(vector))
    if turn > 2 * np.pi:
        raise InputFileError(
            f"{where}: the head is turned by {turn:.0f} radians, more than a full turn",
            "give rotation vectors in radians, not degrees",
        )
