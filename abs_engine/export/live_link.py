"""Live Link Face's CSV: ARKit's 52 weights and the head's angles, frame by frame."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from abs_engine.core.arrays import FloatArray
from abs_engine.core.geometry import FACING, Pose
from abs_engine.dataset.head_angles import live_link_angles
from abs_engine.dataset.timecode import base_below, seconds_since_first, timecodes
from abs_engine.export.exporter import Exporter, Loss, TrackedRun
from abs_engine.export.face_units import unit_loss, unit_weights
from abs_engine.export.reading import compared, numbers, text_cells
from abs_engine.face.schema import SHIFTS, Pair, Unit, units_of

_OF_AN_EYE = (
    Pair.EYE_BLINK, Pair.EYE_LOOK_DOWN, Pair.EYE_LOOK_IN, Pair.EYE_LOOK_OUT, Pair.EYE_LOOK_UP,
    Pair.EYE_SQUINT, Pair.EYE_WIDE,
)  # fmt: skip
ORDER = (
    *(units_of(movement)[side] for side in (0, 1) for movement in _OF_AN_EYE),
    *units_of(
        Unit.JAW_FORWARD, Unit.JAW_LEFT, Unit.JAW_RIGHT, Unit.JAW_OPEN, Unit.MOUTH_CLOSE,
        Unit.MOUTH_FUNNEL, Unit.MOUTH_PUCKER, Unit.MOUTH_LEFT, Unit.MOUTH_RIGHT, Pair.MOUTH_SMILE,
        Pair.MOUTH_FROWN, Pair.MOUTH_DIMPLE, Pair.MOUTH_STRETCH, Unit.MOUTH_ROLL_LOWER,
        Unit.MOUTH_ROLL_UPPER, Unit.MOUTH_SHRUG_LOWER, Unit.MOUTH_SHRUG_UPPER, Pair.MOUTH_PRESS,
        Pair.MOUTH_LOWER_DOWN, Pair.MOUTH_UPPER_UP, Pair.BROW_DOWN, Unit.BROW_INNER_UP,
        Pair.BROW_OUTER_UP, Unit.CHEEK_PUFF, Pair.CHEEK_SQUINT, Pair.NOSE_SNEER, Unit.TONGUE_OUT,
    ),
)  # fmt: skip
"""ARKit's units as packets have them; the head's yaw, pitch and roll follow, and both eyes'."""
_IN_FILES = {a: b for pair in SHIFTS for a, b in (pair, pair[::-1])}
"""Files of the app have these the other way around."""
HEAD = ("HeadYaw", "HeadPitch", "HeadRoll")
EYES = tuple(
    f"{side}Eye{angle}" for side in ("Left", "Right") for angle in ("Yaw", "Pitch", "Roll")
)
_DIGITS = 6


def live_link_columns(run: TrackedRun) -> tuple[str, ...]:
    """The names of the 61 numbers of a frame, in the order of the app's files."""
    names = (run.speaker.unit_names[k] for k in _in_files(run.speaker.unit_names))
    return (*(name[:1].upper() + name[1:] for name in names), *HEAD, *EYES)


def _in_files(units: Sequence[str]) -> list[int]:
    """Places of a head's units in the order of files; those of no other name come last."""
    usual = [_IN_FILES.get(name, name) for name in ORDER]
    known = [units.index(name) for name in usual if name in units]
    return known + [k for k, name in enumerate(units) if name not in usual]


def live_link_rows(run: TrackedRun) -> FloatArray:
    """The 61 numbers of each frame, (T, 61): weights, then radians; NaN in lost frames."""
    weights = unit_weights(run)[:, _in_files(run.speaker.unit_names)]
    angles = live_link_angles(run.turns)
    return np.hstack([weights, run.in_all(np.pad(angles, ((0, 0), (0, len(EYES)))))])


def angles_of(pose: Pose) -> FloatArray:
    """Yaw, pitch and roll of a head to the camera, (3,) radians, as the app has them."""
    return live_link_angles(Rotation.from_matrix(FACING.T @ pose.rotation))


def _write(run: TrackedRun, path: Path) -> tuple[Loss, ...]:
    rows = live_link_rows(run)
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(["Timecode", "BlendShapeCount", *live_link_columns(run)])
        for code, row in zip(timecodes(run.arrays["time"], run.rate), rows, strict=True):
            cells = ["" if np.isnan(x) else f"{x:.{_DIGITS}f}" for x in row]
            table.writerow([code, rows.shape[1], *cells])
    return _read_back(run, path)


def _read_back(run: TrackedRun, path: Path) -> tuple[Loss, ...]:
    read, time = numbers(path, live_link_columns(run)), run.arrays["time"]
    count = len(run.speaker.unit_names)
    weights = read[:, np.argsort(_in_files(run.speaker.unit_names))]
    angles = np.rad2deg(read[:, count : count + len(HEAD)])
    codes = list(text_cells(path, ["Timecode"]))
    seconds = seconds_since_first(codes, path, base_below(run.rate))
    return (
        compared(seconds, time - time[0], "s", "times"),
        *unit_loss(run, weights),
        compared(
            angles, np.rad2deg(run.in_all(live_link_angles(run.turns))), "degrees", "head angles"
        ),
    )


LIVE_LINK = Exporter(
    "Live Link Face's CSV: ARKit's 52 weights and the head's angles", _write, ".csv"
)
