"""Landmark files of other systems, in two layouts.

Long, a line for each point: ``frame,point,x,y,unit`` and perhaps ``time`` (s), ``z``, ``space``.
`point` is 0 to 67 in the order of 300-W; `unit` is ``px`` (x, y in the picture, pixel centres at
integers) or ``mm`` (x, y, z); `space` of mm is ``camera`` (x right, y down, z forward; the default)
or ``head`` (x to the subject's left, y up, z out of the face). A file may give both units.

Wide, a line for each frame, as OpenFace 2 writes it (Baltrusaitis et al. 2018): ``frame`` and
perhaps ``timestamp`` (s), ``success``; ``x_0`` ... ``y_67`` in px, ``X_0`` ... ``Z_67`` in mm,
camera coordinates, and ``pose_Tx`` ... ``pose_Rz`` (mm, radians; R = Rx Ry Rz, no turn being a
face that looks into the camera). px, or mm, or both.

Frames count from 0 or from 1. Every frame of the clip is there; a lost one has empty cells, or
success 0. A point that is given in some frames only is scored in these; see `given` for what it
means for the others.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from abs_engine.core.arrays import BoolArray, FloatArray, IntArray
from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.core.geometry import FACING
from abs_engine.evaluate import metrics
from abs_engine.evaluate.closing import closed_in_picture, narrow
from abs_engine.evaluate.estimate import ClosedBy, Estimate, PointTrack
from abs_engine.evaluate.metrics.curves import landmark_curves
from abs_engine.io.csv_table import Table, read_table

COUNT = 68
EYES_MM = 50.0, 150.0
"""Between these lies the distance of the outer corners of anybody's eyes."""

POSE = ("pose_Rx", "pose_Ry", "pose_Rz"), ("pose_Tx", "pose_Ty", "pose_Tz")


@dataclass(frozen=True, eq=False)
class Reference:
    """The part of the truth that a reader of results needs.

    Parameters
    ----------
    rate : float
        Frames per second.
    neutral : (V, 3) float, mm, head frame
        The person at rest.
    landmark_68 : (68,) int
        The landmarks' vertices.
    """

    frames: int
    rate: float
    neutral: FloatArray
    landmark_68: NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Landmarks:
    """Landmarks of a file; NaN where it has none.

    Parameters
    ----------
    pixels : (T, 68, 2) float64
    points : (T, 68, 3) float64, mm
    space : {"camera", "head"}
    rotations, translations : (T, 3) float64, optional
    """

    pixels: FloatArray
    points: FloatArray
    space: Literal["camera", "head"] = "camera"
    rotations: FloatArray | None = None
    translations: FloatArray | None = None


def read_landmarks(path: Path, clip: Reference) -> Estimate:
    """Read a landmark file as an estimate of a clip.

    Raises
    ------
    InputFileError
        If columns are missing, a cell is no number, or units are not those that are told.
    ParameterError
        If it is of other frames than the clip.
    """
    table = read_table(path)
    read = _long if "point" in table.columns else _wide
    found = read(table, clip)
    _check_units(table.path, found)
    return _estimate(Path(path), found, clip)


def _long(table: Table, clip: Reference) -> Landmarks:
    table.require(("frame", "point", "x", "y", "unit"))
    frame = _frame_rows(table, clip)
    point = table.numbers(["point"])[:, 0]
    places = table.numbers(["x", "y", *(["z"] if "z" in table.columns else [])])
    given = np.isfinite(places).any(axis=1)
    if not np.isin(point[given | np.isfinite(point)], np.arange(COUNT)).all():
        raise InputFileError(f"{table.path} has points other than 0 to 67", "use the 68 of 300-W")
    unit = np.array(table.text("unit"))
    strange = sorted(set(unit[given].tolist()) - {"px", "mm"})
    if strange:
        raise InputFileError(f"{table.path} has the unit '{strange[0]}'", "give px or mm")
    in_mm = (unit == "mm") & given
    if in_mm.any() and places.shape[1] < 3:
        raise InputFileError(f"{table.path} lacks the column z of its points in mm", "add it")
    pixels, points = _empty(clip.frames, 2), _empty(clip.frames, 3)
    for array, rows in ((pixels, given & ~in_mm), (points, in_mm)):
        if not rows.any():  # without mm there need not be three columns
            continue
        which = point[rows].astype(int)
        keys = frame[rows] * COUNT + which
        if len(np.unique(keys)) != len(keys):
            raise InputFileError(f"{table.path} gives a point twice in a frame", "give it once")
        array[frame[rows], which] = places[rows, : array.shape[2]]
    return Landmarks(pixels, points, _space(table, in_mm))


def _space(table: Table, in_mm: BoolArray) -> Literal["camera", "head"]:
    if "space" not in table.columns:
        return "camera"
    named = {name for name, mm in zip(table.text("space"), in_mm, strict=True) if mm}
    if len(named) > 1 or not named <= {"camera", "head"}:
        raise InputFileError(
            f"{table.path} has the spaces {', '.join(sorted(named))}", "give camera or head"
        )
    return "head" if named == {"head"} else "camera"


def _wide(table: Table, clip: Reference) -> Landmarks:
    flat, solid = ([f"{axis}_{k}" for k in range(COUNT) for axis in axes] for axes in ("xy", "XYZ"))
    has_px, has_mm = (any(n in table.columns for n in names) for names in (flat, solid))
    table.require(("frame", *(flat if has_px or not has_mm else ()), *(solid if has_mm else ())))
    frame = _frame_rows(table, clip)
    if len(np.unique(frame)) != len(frame):
        raise InputFileError(f"{table.path} gives a frame twice", "give one face only")
    lost = np.zeros(len(frame), bool)
    if "success" in table.columns:
        lost = table.numbers(["success"])[:, 0] != 1

    def columns(names: Iterable[str], *shape: int) -> FloatArray:
        numbers = table.numbers(names)
        numbers[lost] = np.nan
        ordered = np.empty_like(numbers)
        ordered[frame] = numbers
        return ordered.reshape(clip.frames, *shape)

    pixels = columns(flat, COUNT, 2) if has_px else _empty(clip.frames, 2)
    points = columns(solid, COUNT, 3) if has_mm else _empty(clip.frames, 3)
    if not set(POSE[0] + POSE[1]) <= table.columns.keys():
        return Landmarks(pixels, points)
    angles, moved = (columns(names, 3) for names in POSE)
    return Landmarks(pixels, points, "camera", rotation_vectors(angles, _from_facing), moved)


def _from_facing(angles: FloatArray) -> Rotation:
    """Head to camera, of angles (T, 3) about x, y, z from facing the camera."""
    return Rotation.from_euler("XYZ", angles) * Rotation.from_matrix(FACING)


def rotation_vectors(
    angles: FloatArray, rotation_of: Callable[[FloatArray], Rotation]
) -> FloatArray:
    """Rotation vectors (T, 3) of angles (T, 3), radians; NaN where one of them is not known."""
    vectors = np.full(angles.shape, np.nan)
    known = np.isfinite(angles).all(axis=1)
    vectors[known] = rotation_of(angles[known]).as_rotvec()
    return vectors


def _frame_rows(table: Table, clip: Reference) -> IntArray:
    """The frame of each row, from 0; checked against the frames and times of the clip."""
    given = table.numbers(["frame"])[:, 0]
    if not (np.isfinite(given) & (given == np.floor(given))).all():
        raise InputFileError(f"{table.path} has frames that are not numbers", "count frames")
    known = np.unique(given)
    first = int(known[0])
    if first not in (0, 1) or not np.array_equal(known, first + np.arange(clip.frames)):
        raise ParameterError(
            f"{table.path} has {len(known)} frames from {first} to {int(known[-1])}, "
            f"the truth {clip.frames}",
            "give every frame of this very clip once, lost ones with empty cells",
        )
    frame = given.astype(np.int64) - first
    for name in ("time", "timestamp"):
        if name in table.columns:
            check_times(table.path, table.numbers([name])[:, 0], frame, clip.rate)
    return frame


def check_times(path: Path, times: FloatArray, frame: IntArray, rate: float) -> None:
    """Raise `ParameterError` if times (s) are off by more than half a frame, the first being 0.

    Lost frames may have none.
    """
    known = np.isfinite(times)
    times, frame = times[known], frame[known]
    if not times.size:
        return
    away = times - frame / rate
    away -= away[np.argmin(frame)]
    wrong = np.flatnonzero(~(np.abs(away) <= 0.5 / rate + 1e-3))
    if wrong.size:
        at = wrong[0]
        raise ParameterError(
            f"{path} has frame {frame[at]} at {times[at]:g} s, the truth at {frame[at] / rate:g} s",
            f"give results for this very clip, {rate:g} frames a second",
        )


def _check_units(path: Path, found: Landmarks) -> None:
    """Raise `InputFileError` for pixels or mm that cannot be."""
    pixels = np.abs(found.pixels[np.isfinite(found.pixels)])
    if pixels.size and pixels.max() <= 2:
        raise InputFileError(
            f"the pixels of {path} are all between 0 and {pixels.max():.2g}",
            "multiply shares by the picture's width and height",
        )
    eyes = metrics.interocular(found.points)
    eyes = eyes[np.isfinite(eyes)]
    if eyes.size and not EYES_MM[0] <= np.median(eyes) <= EYES_MM[1]:
        raise InputFileError(
            f"the eyes of {path} are {np.median(eyes):.3g} mm apart", "give points in mm"
        )


def _estimate(path: Path, found: Landmarks, clip: Reference) -> Estimate:
    given = [np.isfinite(a).all(axis=2) for a in (found.pixels, found.points)]
    has_px, has_mm = (bool(points.any()) for points in given)
    tracked = np.asarray(np.any(given[0] | given[1], axis=1))
    tracks: dict[str, PointTrack] = {}
    curves: dict[str, FloatArray] = {}
    rest = clip.neutral[clip.landmark_68]
    closed = closed_in_picture(found.pixels, rest)
    by: ClosedBy = "picture"
    if has_mm:
        ever = given[1].any(axis=0)
        track = PointTrack(clip.landmark_68[ever], found.points[:, ever], found.space)
        tracks["landmarks"] = track
        curves = landmark_curves(found.points, None if found.space == "head" else rest)
        if np.isfinite(curves["aperture"]).any():
            closed, by = narrow(curves["aperture"]), "aperture"
    return Estimate(
        name=path.stem,
        found=tracked,
        tracks=tracks,
        rotations=found.rotations,
        translations=found.translations,
        closed=closed,
        closed_by=by,
        pixels=found.pixels if has_px else None,
        curves=curves,
        curves_on="axes" if found.space == "head" else "rest",
    )


def _empty(frames: int, axes: int) -> FloatArray:
    return np.full((frames, COUNT, axes), np.nan)
