"""OpenFace 2's CSV: head pose and 68 landmarks; columns of what is not measured stay empty."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from abs_engine.core.arrays import FloatArray
from abs_engine.core.geometry import FACING
from abs_engine.export.exporter import Exporter, Loss, TrackedRun
from abs_engine.export.reading import compared, numbers

_AXES = "XYZ"
GAZE = (*(f"gaze_{eye}_{axis}" for eye in (0, 1) for axis in "xyz"), "gaze_angle_x", "gaze_angle_y")
EYES = (
    *(f"eye_lmk_{axis}_{k}" for axis in "xy" for k in range(56)),
    *(f"eye_lmk_{axis}_{k}" for axis in _AXES for k in range(56)),
)
POSE = tuple(f"pose_{kind}{axis.lower()}" for kind in "TR" for axis in _AXES)
PIXELS = tuple(f"{axis}_{k}" for axis in "xy" for k in range(68))
PLACES = tuple(f"{axis}_{k}" for axis in _AXES for k in range(68))
SHAPE = (
    "p_scale", "p_rx", "p_ry", "p_rz", "p_tx", "p_ty", *(f"p_{k}" for k in range(34)),
)  # fmt: skip
_UNITS = (1, 2, 4, 5, 6, 7, 9, 10, 12, 14, 15, 17, 20, 23, 25, 26, 45)
ACTIONS = (*(f"AU{k:02d}_r" for k in _UNITS), *(f"AU{k:02d}_c" for k in sorted({*_UNITS, 28})))
BEGIN = ("frame", "face_id", "timestamp", "confidence", "success")


def _write(run: TrackedRun, path: Path) -> tuple[Loss, ...]:
    pixels, places, pose = run.landmarks_in_picture, run.landmarks_in_camera, _pose(run)
    score = run.arrays["score"] if "score" in run.arrays else np.where(run.shown, 1.0, 0.0)
    empty_before, empty_after = [""] * len((*GAZE, *EYES)), [""] * len((*SHAPE, *ACTIONS))
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow([*BEGIN, *GAZE, *EYES, *POSE, *PIXELS, *PLACES, *SHAPE, *ACTIONS])
        for k, found in enumerate(run.shown):
            begin = [k + 1, 0, f"{run.arrays['time'][k]:.3f}", f"{np.nan_to_num(score[k]):.2f}"]
            cells = _cells(pose[k], ".3f"), _cells(pixels[k].T, ".2f"), _cells(places[k].T, ".2f")
            table.writerow(
                [*begin, int(found), *empty_before, *cells[0], *cells[1], *cells[2], *empty_after]
            )
    return _read_back(run, path)


def _read_back(run: TrackedRun, path: Path) -> tuple[Loss, ...]:
    read = numbers(path, ["timestamp", *POSE, *PIXELS, *PLACES])
    times, place, angles, pixels, places = np.split(read, np.cumsum([1, 3, 3, len(PIXELS)]), axis=1)
    pose = _pose(run)
    return (
        compared(times[:, 0], run.arrays["time"], "s", "times"),
        compared(place, pose[:, :3], "mm", "place of the head"),
        compared(np.rad2deg(angles), np.rad2deg(pose[:, 3:]), "degrees", "head angles"),
        compared(_points(pixels, 2), run.landmarks_in_picture, "px", "68 landmarks in the picture"),
        compared(
            _points(places, 3), run.landmarks_in_camera, "mm", "68 landmarks before the camera"
        ),
    )


def _points(columns: FloatArray, axes: int) -> FloatArray:
    """Points (T, 68, axes) of columns that have one axis after the other."""
    return columns.reshape(len(columns), axes, -1).transpose(0, 2, 1)


def _pose(run: TrackedRun) -> FloatArray:
    """Place (mm) and angles (radians, camera axes, R = Rx Ry Rz) of the head, (T, 6)."""
    turned = Rotation.from_matrix([run.pose(frame).rotation @ FACING for frame in run.frames])
    moved = run.arrays["translation"][run.frames]
    return run.in_all(np.hstack([moved, turned.as_euler("XYZ")]))


def _cells(numbers: FloatArray, digits: str) -> list[str]:
    return ["" if np.isnan(x) else format(x, digits) for x in numbers.ravel()]


OPENFACE = Exporter("OpenFace 2's CSV: pose and 68 landmarks, the rest empty", _write, ".csv")
