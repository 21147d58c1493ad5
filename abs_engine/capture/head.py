"""The head frame as a user chooses it: by settings, and by files of poses or reference points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from abs_engine.capture.headframe import (
    AXES,
    HeadMotion,
    check_names,
    follow_point,
    mouth_axes,
    reference_of,
    rigid_motion,
)
from abs_engine.capture.recorded import refuse_turn
from abs_engine.capture.settings import CAPTURE
from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import InputFileError, ParameterError, TooFewPointsError
from abs_engine.core.pose import POSE_NAMES
from abs_engine.io.csv_table import Table, read_table


@dataclass(frozen=True, eq=False)
class HeadChoice:
    """One of three ways to the head frame.

    Parameters
    ----------
    rigid : sequence of str
        Three or more points of the skull.
    reference : mapping of str to (3,) float64, mm, optional
        Where the rigid points are in the head frame. Without it the axes are those of
        `mouth_axes` in the first frame in which they can be told, the origin is the nose.
    motion : HeadMotion, optional
        The head's pose, from elsewhere.
    unturned : str, optional
        A point of the skull, for a head that is held so that it does not turn: only its shift is
        removed. Axes and origin as without a reference.
    """

    rigid: Sequence[str] = ()
    reference: Mapping[str, FloatArray] | None = None
    motion: HeadMotion | None = None
    unturned: str | None = None

    @property
    def needed(self) -> frozenset[str]:
        """Points that this way needs; by a given pose, none."""
        if self.motion is not None:
            return frozenset()
        axes = () if self.reference is not None else (*AXES, "nose")
        unturned = () if self.unturned is None else (self.unturned,)
        return frozenset((*self.rigid, *unturned, *axes))

    def check(self, names: Sequence[str]) -> None:
        """Raise unless exactly one way is chosen and its points are among the names.

        Raises
        ------
        ParameterError
            If several ways are chosen, or a point has no such name.
        TooFewPointsError
            If none is, or fewer than three rigid points are named.
        ModelFormatError
            If the reference lacks a rigid point.
        """
        ways = [bool(self.rigid), self.motion is not None, self.unturned is not None]
        if sum(ways) > 1:
            raise ParameterError(
                "the head frame is given in several ways",
                "choose rigid points, the head's pose, or a head that does not turn",
            )
        if not any(ways):
            raise TooFewPointsError(
                "nothing is said about the head's motion, and the nose alone does not fix its "
                "rotation",
                "name three points of the skull (--rigid), give the head's pose (--pose), or say "
                "that the head does not turn (--unturned)",
            )
        check_names(names, [*self.rigid, *([self.unturned] if self.unturned else [])])
        if self.rigid and len(set(self.rigid)) < 3:
            raise TooFewPointsError(
                f"{len(set(self.rigid))} rigid points do not fix the head's rotation",
                "name three or more that do not move with the face",
            )
        if self.reference is not None:
            reference_of(self.reference, self.rigid)


def head_motion(points: FloatArray, names: Sequence[str], choice: HeadChoice) -> HeadMotion:
    """The head's motion in the chosen way.

    Parameters
    ----------
    points : (T, N, 3) float64, mm, world frame; NaN where not known

    Raises
    ------
    ParameterError, ModelFormatError
        See `HeadChoice.check`.
    TooFewPointsError, DegenerateViewsError
        If the points do not tell the head's rotation.
    ParameterError
        If the points lie far from the head whose pose is given, or the rigid ones do not lie as the
        reference has them.
    """
    choice.check(names)
    if choice.motion is not None:
        _check_near(choice.motion.to_head(points))
        return choice.motion
    if choice.unturned is not None:
        at = int(check_names(names, [choice.unturned])[0])
        axes = mouth_axes(points[_whole(points, names)], names)
        return follow_point(points[:, at], axes)
    rigid = points[:, check_names(names, choice.rigid)]
    if choice.reference is not None:
        given = reference_of(choice.reference, choice.rigid)
        motion = rigid_motion(rigid, given)
        _check_reference(motion.to_head(rigid), given)
        return motion
    motion = rigid_motion(rigid)
    start = rigid[int(np.isfinite(rigid).all(axis=(1, 2)).argmax())]
    placed = motion.to_head(points)
    if "nose" in names:
        nose = list(names).index("nose")
        placed = placed[np.isfinite(placed[:, nose]).all(axis=1)]
        if not len(placed):
            raise TooFewPointsError(
                "'nose', the origin of the head frame, is found in no frame",
                "record it, or give a reference of the rigid points (--reference)",
            )
    steady = placed[_whole(placed, names)]
    axes = mouth_axes(steady, names)
    origin = steady[nose] if "nose" in names else np.nanmean(steady, axis=0)
    return rigid_motion(rigid, (start - origin) @ axes.T)


def _check_near(placed: FloatArray) -> None:
    """Refuse points (T, N, 3), mm, head frame, most of which lie too far off to be on the head."""
    away = np.linalg.norm(placed, axis=2)
    away = away[np.isfinite(away)]
    if len(away) and np.median(away) > CAPTURE.farthest:
        raise ParameterError(
            f"by the head's poses, the points lie {np.median(away):.0f} mm from its origin",
            "give poses in radians and mm, which take points of the head to the first camera's "
            "frame",
        )


def _check_reference(placed: FloatArray, given: FloatArray) -> None:
    """Refuse rigid points (T, K, 3), mm, head frame, whose shape is not that of a reference."""
    off = np.nanmean(placed, axis=0) - given
    error = float(np.sqrt((off**2).sum(axis=1).mean()))
    if error > CAPTURE.off_reference:
        raise ParameterError(
            f"the rigid points lie {error:.0f} mm RMS off the reference",
            "give their places in mm, x to the subject's left, and check that no names or sides "
            "are exchanged",
        )


def _whole(points: FloatArray, names: Sequence[str]) -> int:
    """The frame with most points, if possible one with the dots of the mouth's axes."""
    there = np.asarray(np.isfinite(points).all(axis=2))
    needed = [k for k, name in enumerate(names) if name in AXES]
    return int((there.sum(axis=1) + len(names) * there[:, needed].all(axis=1)).argmax())


_REMEDY = "name the columns in line 1"


def read_head_poses(path: Path, frames: int, first: int = 0) -> HeadMotion:
    """Read a CSV of the head's pose: columns frame, rx, ry, rz (radians), tx, ty, tz (mm).

    Rotation vector and translation take head points to the world (that of the first camera).
    Empty cells: not known. Lines of other frames are ignored.

    Parameters
    ----------
    frames, first : int
        Number of frames, and the number of the first.

    Raises
    ------
    InputFileError
        If the file is missing, lacks a column or a frame or has one twice, a value is no number, or
        a rotation is more than a full turn.
    """
    table = read_table(path, empty_lines=True, small=True)
    table.require(("frame", *POSE_NAMES), _REMEDY)
    out = np.full((frames, 6), np.nan)
    lines = _lines_of_frames(table)
    poses = table.numbers(POSE_NAMES, gaps=True)
    for k in range(frames):
        if first + k not in lines:
            raise InputFileError(
                f"{path} has no line for frame {first + k}",
                f"give frames {first} to {first + frames - 1}",
            )
        out[k] = poses[lines[first + k]]
    out[~np.isfinite(out).all(axis=1)] = np.nan
    for frame, vector in enumerate(out[:, :3], start=first):
        refuse_turn(f"{path}, frame {frame}", vector)
    return HeadMotion(out[:, :3], out[:, 3:], np.where(np.isnan(out[:, 0]), np.nan, 0.0))


def _lines_of_frames(table: Table) -> Mapping[int, int]:
    """The row of each frame; rows without a frame are left out."""
    out: dict[int, int] = {}
    for row, number in enumerate(table.numbers(["frame"])[:, 0].tolist()):
        if np.isnan(number):
            continue
        where = f"{table.path}, line {table.lines[row]}"
        if not number.is_integer():
            raise InputFileError(
                f"{where}: '{number:g}' is not a frame number", "use whole numbers"
            )
        if int(number) in out:
            raise InputFileError(f"{where}: frame {number:.0f} is given twice", "keep one")
        out[int(number)] = row
    return out


def read_reference(path: Path) -> Mapping[str, FloatArray]:
    """Read where points are in the head frame, a CSV of point, x, y, z (mm).

    Raises
    ------
    InputFileError
        If the file is missing, lacks a column, has a point twice, or a value is no number.
    """
    table = read_table(path, small=True)
    table.require(("point", *"xyz"), _REMEDY)
    out: dict[str, FloatArray] = {}
    for line, name, place in zip(
        table.lines, table.text("point"), table.numbers("xyz", gaps=True), strict=True
    ):
        if not np.isfinite(place).all():
            raise InputFileError(f"{path} has no place for '{name}'", "give x, y and z")
        if name in out:
            raise InputFileError(f"{path}, line {line}: point '{name}' is given twice", "keep one")
        out[name] = place
    return out
