"""The tables of a run for spreadsheets: a row for each frame, and one for each closure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.pose import POSE_NAMES, parted
from abs_engine.io.assets import CLOSED_APERTURE, LIPS_OF_68
from abs_engine.tracking.clip_setting import ClipSetting, FrameResult
from abs_engine.tracking.measures import NAMES, Closure
from abs_engine.tracking.run_warnings import contradicted

FloatArray = NDArray[np.float64]

POINT_NAMES = tuple(f"lip{k}" for k in range(68)[LIPS_OF_68])
"""The 20 lip points by their numbers among the usual 68: 12 outer, then 8 inner."""


BELIEVED = ("width", "aperture", "protrusion")
LANDMARK_MEASURES = ("landmark_distance", "landmark_aperture")
_SURE = (*(f"{name}_sd" for name in BELIEVED), "closed_probability")


def table_of(
    setting: ClipSetting,
    results: Sequence[FrameResult],
    times: FloatArray,
    measured: Mapping[str, FloatArray],
) -> list[list[Any]]:
    """The table of all frames, its heading first.

    Parameters
    ----------
    setting : ClipSetting
    results : sequence of FrameResult
        T of them.
    times : (T,) float64, s
    measured : mapping of str to (T,) float64
        As `measures` gives them.
    """
    more = np.array([measured[name] for name in NAMES]).T.tolist()
    rows = zip(results, times.tolist(), more, strict=True)
    return [heading(setting), *(_row(setting, *row) for row in rows)]


def heading(setting: ClipSetting) -> list[str]:
    """Column names of ``results.csv``."""
    points = [f"{name}_{axis}" for name in POINT_NAMES for axis in "xyz"]
    pose = [f"head_{name}" for name in POSE_NAMES]
    parameters = setting.face.blocks.spec.names
    end = ["width", "aperture", "closed", "value", "score", "evaluations", "covered"]
    end += [*LANDMARK_MEASURES, "protrusion", *_SURE, "contradicted", *NAMES, "status"]
    return ["index", "time", "found", *pose, *parameters, *points, *end]


def _row(setting: ClipSetting, result: FrameResult, time: float, more: list[float]) -> list[Any]:
    points = np.full((len(POINT_NAMES), 3), np.nan)
    if result.found:
        vertices = setting.face.scene.vertices(parted(result.vector)[1])
        points = vertices[setting.face.rings["points"]]
    return [
        result.index, time, int(result.found), *rotation_vector(result), *translation(result),
        *result.vector, *points.ravel(), result.width, result.aperture,
        int(closed_frames(result.aperture)), result.value, result.score, result.evaluations,
        int(result.covered), result.landmark_distance, result.landmark_aperture, result.protrusion,
        *(float(believed(result, name, ())) for name in _SURE),
        int(contradicted_frames([result])[0]), *more, result.status,
    ]  # fmt: skip


def closure_table(found: Iterable[Closure]) -> list[list[Any]]:
    """The table of ``closures.csv``, its heading first."""
    names = ["onset", "release", "duration", "first_frame", "last_frame", "least_aperture"]
    rows = [[c.onset, c.release, c.release - c.onset, c.first, c.last, c.least] for c in found]
    return [list(names), *rows]


def cells(row: Iterable[Any]) -> list[Any]:
    """A row as it is written: numbers short enough to read, empty where they are NaN."""
    return [_cell(value) for value in row]


def _cell(value: Any) -> Any:
    if isinstance(value, float):  # NumPy's float64 is one
        return "" if np.isnan(value) else f"{value:.6g}"
    return value


def believed(result: FrameResult, name: str, size: tuple[int, ...]) -> NDArray[np.float64]:
    """A number of a frame's belief by its name in results; NaN where there is none."""
    if result.belief is None:
        return np.full(size, np.nan)
    own = {"lip_points_sd": "lips", "closed_probability": "closed"}.get(name)
    return np.asarray(getattr(result.belief, own or name.removesuffix("_sd")), np.float64)


def contradicted_frames(results: Sequence[FrameResult]) -> NDArray[np.bool_]:
    """Mask of the frames whose apertures landmarks contradict, (T,)."""
    own = [believed(r, "aperture_sd", ()) for r in results]
    by = [(r.aperture, r.landmark_aperture) for r in results]
    aperture, told = np.array(by, np.float64).reshape(-1, 2).T
    return contradicted(aperture, np.array(own, np.float64).reshape(-1), told)


def closed_frames(aperture: Any) -> NDArray[np.bool_]:
    """Whether lips of an aperture in mm count as closed; never where it is NaN."""
    return np.asarray(np.asarray(aperture) < CLOSED_APERTURE)


def rotation_vector(result: FrameResult) -> NDArray[np.float64]:
    """Head to camera as a rotation vector (3,), radians; NaN in a lost frame."""
    return np.full(3, np.nan) if result.pose is None else result.pose.rotation_vector


def translation(result: FrameResult) -> NDArray[np.float64]:
    """Head to camera, (3,), mm; NaN in a lost frame."""
    return np.full(3, np.nan) if result.pose is None else result.pose.translation
