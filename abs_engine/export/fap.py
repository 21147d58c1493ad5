"""MPEG-4 facial animation parameters (ISO/IEC 14496-2, annex C): lips, jaw and head.

A text file as FAP players read it: a line with version, name, frames per second and number of
frames; then for each frame a mask of 68 flags, and the frame's number with the parameters whose
flags are set. Distances are from the neutral face, whose lips meet, in facial animation parameter
units (FAPU), thousandths (1/1024) of distances in it; head angles in units of 1e-5 radian, with
regard to the camera's axes.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.export.exporter import Exporter, Loss, TrackedRun
from abs_engine.export.reading import compared

_NOSE, _CHIN, _CORNERS, _MIDDLE = 33, 8, (48, 54), 62  # 9.15, 2.10, 8.4 and 8.3, 2.2
_X, _Y, _Z = 0, 1, 2

# Number of the parameter: its unit, the landmark of 300-W it moves, the axis, and the sense.
# The landmarks of the subject's left, MPEG-4's left, are those of the greater x.
LIPS: dict[int, tuple[str, int, int, float]] = {
    4: ("MNS", 62, _Y, -1.0),  # lower_t_midlip
    5: ("MNS", 66, _Y, 1.0),  # raise_b_midlip
    6: ("MW", 64, _X, 1.0),  # stretch_l_cornerlip
    7: ("MW", 60, _X, -1.0),  # stretch_r_cornerlip
    8: ("MNS", 63, _Y, -1.0),  # lower_t_lip_lm
    9: ("MNS", 61, _Y, -1.0),  # lower_t_lip_rm
    10: ("MNS", 65, _Y, 1.0),  # raise_b_lip_lm
    11: ("MNS", 67, _Y, 1.0),  # raise_b_lip_rm
    12: ("MNS", 64, _Y, 1.0),  # raise_l_cornerlip
    13: ("MNS", 60, _Y, 1.0),  # raise_r_cornerlip
    16: ("MNS", 66, _Z, 1.0),  # push_b_lip
    17: ("MNS", 62, _Z, 1.0),  # push_t_lip
    18: ("MNS", 8, _Y, 1.0),  # depress_chin
    51: ("MNS", 51, _Y, -1.0),  # lower_t_midlip_o
    52: ("MNS", 57, _Y, 1.0),  # raise_b_midlip_o
    53: ("MW", 54, _X, 1.0),  # stretch_l_cornerlip_o
    54: ("MW", 48, _X, -1.0),  # stretch_r_cornerlip_o
    55: ("MNS", 52, _Y, -1.0),  # lower_t_lip_lm_o
    56: ("MNS", 50, _Y, -1.0),  # lower_t_lip_rm_o
    57: ("MNS", 56, _Y, 1.0),  # raise_b_lip_lm_o
    58: ("MNS", 58, _Y, 1.0),  # raise_b_lip_rm_o
    59: ("MNS", 54, _Y, 1.0),  # raise_l_cornerlip_o
    60: ("MNS", 48, _Y, 1.0),  # raise_r_cornerlip_o
}
_OPEN_JAW, _HEAD = 3, (48, 49, 50)  # head_pitch, head_yaw, head_roll
_AU = 1e-5  # rad
_COUNT = 68


def neutral(run: TrackedRun) -> FloatArray:
    """The 68 landmarks of the person's neutral face, (68, 3) float64, mm, head frame."""
    return run.neutral[run.speaker.points["landmark_68"]]


def fapu(run: TrackedRun) -> dict[str, float]:
    """FAPU of the tracked person, mm: mouth-nose separation and mouth width, over 1024."""
    rest = neutral(run)
    width = abs(float(np.diff(rest[_CORNERS, _X])[0]))
    return {"MNS": abs(float(rest[_NOSE, _Y] - rest[_MIDDLE, _Y])) / 1024, "MW": width / 1024}


def parameters(run: TrackedRun) -> dict[int, FloatArray]:
    """The parameters that are given, each (T,) in its unit; NaN in lost frames."""
    moved, units = run.landmarks - neutral(run), fapu(run)
    out = {k: s * moved[:, p, a] / units[u] for k, (u, p, a, s) in LIPS.items()}
    if "jaw_opening" in run.arrays:
        out[_OPEN_JAW] = run.arrays["jaw_opening"] / units["MNS"]
    # R = Ry(yaw) Rx(pitch) Rz(roll)
    yaw, pitch, roll = run.in_all(run.turns.as_euler("YXZ")).T
    out |= dict(zip(_HEAD, (pitch / _AU, yaw / _AU, roll / _AU), strict=True))
    return {k: np.where(run.shown, values, np.nan) for k, values in sorted(out.items())}


def _write(run: TrackedRun, path: Path) -> tuple[Loss, ...]:
    given = parameters(run)
    table = np.array(list(given.values())).T
    known = np.isfinite(table)
    steps = np.where(known, np.round(np.nan_to_num(table)), 0).astype(int)
    with path.open("w", encoding="ascii") as file:
        file.write(f"2.1 abs_engine {run.rate:g} {len(run)}\n")
        for frame, (row, there) in enumerate(zip(steps, known, strict=True)):
            flags = np.zeros(_COUNT, int)
            flags[np.array(list(given))[there] - 1] = 1
            file.write(" ".join(map(str, flags)) + "\n")
            file.write(" ".join(map(str, [frame, *row[there]])) + "\n")
    return _losses(run, given, *_read(path))


def _read(path: Path) -> tuple[FloatArray, FloatArray]:
    """Times (T,) of frames, s, and parameters by number, (69, T); NaN where they are not given."""
    head, *lines = path.read_text(encoding="ascii").splitlines()
    steps = np.full((len(lines) // 2, _COUNT + 1), np.nan)  # at 0 the number of the frame
    for out, flags, row in zip(steps, lines[::2], lines[1::2], strict=True):
        out[np.array(["1", *flags.split()]) == "1"] = list(map(int, row.split()))
    return steps[:, 0] / float(head.split()[2]), steps.T


def _losses(
    run: TrackedRun, given: Mapping[int, FloatArray], times: FloatArray, columns: FloatArray
) -> tuple[Loss, ...]:
    """The lips that a player can rebuild from these numbers alone, beside those tracked."""
    rebuilt, units = np.tile(neutral(run), (len(run), 1, 1)), fapu(run)
    for number, (unit, point, axis, sense) in LIPS.items():
        rebuilt[:, point, axis] += sense * columns[number] * units[unit]
    rebuilt[np.isnan(columns[_HEAD[0]])] = np.nan
    lips = sorted({point for _, point, _, _ in LIPS.values()} - {_CHIN})
    sizes = {**{k: units[unit] for k, (unit, *_) in LIPS.items()}, _OPEN_JAW: units["MNS"]}
    moved, turned = sizes.keys() & given.keys(), np.rad2deg(_AU)
    long, true = (np.concatenate([one[k] * sizes[k] for k in moved]) for one in (columns, given))
    read, angles = (np.stack([one[k] for k in _HEAD], axis=1) for one in (columns, given))
    begun = run.arrays["time"] - run.arrays["time"][0]
    return (
        compared(times, begun, "s", "times", _note(run, begun - times)),
        compared(long, true, "mm", "coordinates that have a parameter"),
        compared(
            rebuilt[:, lips], run.landmarks[:, lips], "mm", "points of the lips",
            by="MPEG-4's parameters",
        ),
        compared(read * turned, angles * turned, "degrees", "head angles"),
    )  # fmt: skip


def _note(run: TrackedRun, late: FloatArray) -> str:
    """Line about times that the format, with its one rate, cannot state; usually empty."""
    off = np.abs(late).max()
    if off <= 0.5 / run.rate:
        return ""
    return (
        f"FAP frames are evenly spaced; this video's are not: times are off by up to {off:.3f} s; "
        "convert the video to a constant rate before you track it"
    )


FAP = Exporter("MPEG-4 facial animation parameters of lips, jaw and head", _write, ".fap")
