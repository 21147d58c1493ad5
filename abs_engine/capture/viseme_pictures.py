"""Table of pictures of visemes: which file shows which viseme, and where the head is in it.

A CSV file with the columns ``picture``, a file beside the table, and ``viseme``. Perhaps also
``rx`` to ``rz``, a rotation vector in radians, and ``tx`` to ``tz``, a translation in mm: the pose
of the points' frame in the camera's axes (x right, y down, z forward). A line whose six cells are
empty has a pose that is to be estimated, and so have all without these columns.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from abs_engine.capture.recorded import refuse_turn
from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import POSE_NAMES
from abs_engine.io.csv_table import read_table

HELP = "see 'abs-engine articulate --help' for what a table of pictures holds"


@dataclass(frozen=True)
class VisemePicture:
    """A picture of a viseme.

    Parameters
    ----------
    pose : Pose or None
        The points' frame to the camera; None where it is to be estimated.
    """

    path: Path
    viseme: str
    pose: Pose | None


def read_viseme_pictures(path: Path, visemes: Collection[str]) -> tuple[VisemePicture, ...]:
    """Read a table as the module describes it, of a corpus with these visemes.

    Raises
    ------
    InputFileError
        If it cannot be read, lacks a column or has no lines, names a picture that is not there, or
        turns a head by more than a full turn.
    ParameterError
        If it names a viseme that the corpus does not have, or a part of a pose.
    """
    table = read_table(path)
    table.require(("picture", "viseme"), HELP)
    placed = any(name in table.columns for name in POSE_NAMES)
    if placed:
        table.require(POSE_NAMES, HELP)
    numbers = table.numbers(POSE_NAMES if placed else ())
    out = []
    rows = zip(table.lines, table.text("picture"), table.text("viseme"), numbers, strict=True)
    for line, name, viseme, row in rows:
        where = f"{path}, line {line}"
        picture = path.parent / name
        if not name or not picture.is_file():
            raise InputFileError(f"{where}: there is no picture {name!r}", "name a file beside it")
        if viseme not in visemes:
            raise ParameterError(
                f"{where}: there is no viseme {viseme!r}", f"choose one of {', '.join(visemes)}"
            )
        there = np.isfinite(row)
        if there.any() and not there.all():
            raise ParameterError(f"{where}: a part of the pose is missing", "give all, or none")
        refuse_turn(where, row[:3])
        known = placed and bool(there.all())
        pose = Pose.from_vectors(row[:3], row[3:]) if known else None
        out.append(VisemePicture(picture, viseme, pose))
    return tuple(out)
