"""Reads a table of labelled frames: points on the inner lips in close-ups of mouths."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import InputFileError
from abs_engine.core.words import counted
from abs_engine.io.csv_table import read_table
from abs_engine.io.video import read_frames
from abs_engine.learn.opening import POINTS, LabelledMouth, spot_of

COLUMNS = tuple(f"{name}_{axis}" for name in POINTS for axis in "xy")
_CROSSED = 0.05, 2.0  # of a mouth's width, and px: labels of closed lips may cross by as much
_NARROWEST = 0.05
"""Share of the picture's width, of a mouth in a close-up at least. Chosen: real ones have 0.4."""
_REMEDY = "see 'abs-engine mouths --help'"


def read_mouths(path: Path) -> list[LabelledMouth]:
    """The labelled frames of a table.

    It is a CSV file with a row for each frame: `video`, its path from the table's folder; `frame`,
    counted from 0; and `COLUMNS`, pixels whose centres are at integers.

    Raises
    ------
    InputFileError, VideoError
        If the table or a video cannot be read, a cell is empty, a frame is labelled twice or is no
        whole number, points are not where their names say or no pixels of the picture, or a video
        ends before a frame; or if no mouth is open.
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
    _check_rows(path, table.lines, videos, numbers)
    found: list[LabelledMouth] = []
    for video in dict.fromkeys(videos):
        rows = numbers[[k for k, name in enumerate(videos) if name == video]]
        points = {int(row[0]): row[1:].reshape(-1, 2) for row in rows}
        spot, last = spot_of(list(points.values())), max(points)
        for index, image in enumerate(read_frames(path.parent / video)):
            if index in points:
                found.append(LabelledMouth(image, points.pop(index), spot))
                _check_pixels(f"{path}, frame {index} of {video}", found[-1])
            if index == last:
                break
        if points:
            raise InputFileError(
                f"{video} has {counted(index + 1, 'frame')} and no frame {min(points)}",
                f"count frames from 0 in {path}",
            )
    if not any(mouth.parted for mouth in found):
        raise InputFileError(
            f"{path}: no open mouth is labelled", "label frames in which the lips are parted, too"
        )
    return found


def _check_rows(
    path: Path, lines: Sequence[int], videos: Sequence[str], numbers: FloatArray
) -> None:
    """Raise `InputFileError` for the first row (17,), frame and points, that cannot be right."""
    seen: set[tuple[str, float]] = set()
    for line, video, (frame, *flat) in zip(lines, videos, numbers, strict=True):
        problem = _problem(np.reshape(flat, (-1, 2)))
        if frame < 0 or frame % 1:
            problem = f"frame {frame:g} is not a whole number", "count frames from 0"
        elif (video, frame) in seen:
            problem = f"frame {frame:g} of {video} is labelled twice", "leave out one of them"
        if problem:
            raise InputFileError(f"{path}, line {line}: {problem[0]}", problem[1])
        seen.add((video, frame))


def _problem(points: FloatArray) -> tuple[str, str] | None:
    """Fault of points (8, 2) whose names do not fit their places, and a remedy; else None."""
    left, right, *others = points
    if right[0] <= left[0]:
        return "the left corner is not left of the right one", "left and right are the picture's"
    along = (right - left) / np.linalg.norm(right - left)
    down = np.array([point @ [-along[1], along[0]] for point in others])
    lower = np.array([name.startswith("lower") for name in POINTS[2:]])
    share, least = _CROSSED
    far = max(least, share * float(np.linalg.norm(right - left)))
    if down[~lower].mean() - down[lower].mean() > far:
        return "the upper lip lies below the lower one", "rows of a picture count downwards"
    across = dict(zip(POINTS[2:], np.array(others) @ along, strict=True))
    for lip in ("upper", "lower"):
        if not across[f"{lip}_left"] <= across[lip] <= across[f"{lip}_right"]:
            return f"points of the {lip} lip are out of order", "left and right are the picture's"
    return None


def _check_pixels(where: str, mouth: LabelledMouth) -> None:
    """Raise `InputFileError` for a mouth that cannot be in its picture.

    It is far too narrow, or a point lies half a mouth or more outside.
    """
    size = np.array(mouth.image.shape[1::-1])
    width = float(np.linalg.norm(mouth.points[1] - mouth.points[0]))
    if width < _NARROWEST * size[0]:
        raise InputFileError(
            f"{where}: the mouth is {width:.1f} px wide in a picture of {size[0]}",
            "give pixels, not shares of the picture",
        )
    beyond = np.maximum(-mouth.points, mouth.points - (size - 1)).max()
    if beyond > mouth.spot.width / 2:
        raise InputFileError(f"{where}: a point lies outside of the picture", "give pixels of it")
