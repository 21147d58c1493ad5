"""Reads a table of labelled frames: points on the inner lips in close-ups of mouths."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from abs_engine.core.errors import InputFileError
from abs_engine.io.csv_table import read_table
from abs_engine.io.video import read_frames
from abs_engine.learn.opening import POINTS, LabelledMouth, spot_of

COLUMNS = tuple(f"{name}_{axis}" for name in POINTS for axis in "xy")
_REMEDY = "see 'abs-engine mouths --help'"


def read_mouths(path: Path) -> list[LabelledMouth]:
    """The labelled frames of a table.

    Parameters
    ----------
    path : Path
        A CSV file with a row for each frame: `video`, its path from the table's folder; `frame`,
        counted from 0; and `COLUMNS`, pixels whose centres are at integers.

    Raises
    ------
    InputFileError, VideoError
        If the table or a video cannot be read, a cell is empty, or a video ends before a frame.
    """
    table = read_table(path)
    table.require(("video", "frame", *COLUMNS), _REMEDY)
    numbers = table.numbers(("frame", *COLUMNS))
    empty = np.flatnonzero(np.isnan(numbers).any(axis=1))
    if len(empty):
        raise InputFileError(
            f"{path}, line {table.lines[empty[0]]}: a cell is empty", "label every point"
        )
    videos = table.text("video")
    found: list[LabelledMouth] = []
    for video in dict.fromkeys(videos):
        rows = numbers[[k for k, name in enumerate(videos) if name == video]]
        points = {int(row[0]): row[1:].reshape(-1, 2) for row in rows}
        spot, last = spot_of(list(points.values())), max(points)
        for index, image in enumerate(read_frames(path.parent / video)):
            if index in points:
                found.append(LabelledMouth(image, points.pop(index), spot))
            if index == last:
                break
        if points:
            raise InputFileError(
                f"{video} has no frame {min(points)}", f"count frames from 0 in {path}"
            )
    return found
