"""The quantities that a report draws frame by frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.evaluate.estimate import NORMAL_95
from abs_engine.evaluate.metrics import Mean
from abs_engine.report.data import Quantity, Series

CURVES = (
    Quantity("aperture", "aperture", "mm"),
    Quantity("width", "width", "mm"),
    Quantity("protrusion", "protrusion", "mm"),
)

SURENESS = (
    Quantity("score", "score", "0 to 1"),
    Quantity("aperture_half", "± aperture", "mm"),
    Quantity("width_half", "± width", "mm"),
    Quantity("landmark_distance", "off landmarks", "mm"),
)
"""How sure a run is of its frames, without any truth: half widths are of 95 % intervals."""

SHARE = "share"
"""Unit of what is no error: the share of a frame's coordinates that lie in their intervals."""

_LIPS = (
    Quantity("lip_landmarks_rms_head_mm", "lip landmarks", "mm"),
    Quantity("lip_landmarks_rms_camera_mm", "lip landmarks (camera)", "mm"),
)
_MESH = (
    Quantity("lips_rms_head_mm", "lips", "mm"),
    Quantity("face_rms_head_mm", "face", "mm"),
    Quantity("jaw_rms_head_mm", "jaw", "mm"),
)
_POINTS = (
    Quantity("lip_points_rms_head_mm", "lip points", "mm"),
    Quantity("landmarks_rms_head_mm", "68 landmarks", "mm"),
    Quantity("lip_points_rms_camera_mm", "lip points (camera)", "mm"),
    Quantity("landmarks_rms_camera_mm", "68 landmarks (camera)", "mm"),
)
_PICTURE = (
    Quantity("lips_rms_px", "lips (picture)", "px"),
    Quantity("landmarks_rms_px", "68 landmarks (picture)", "px"),
)
_POSE = (
    Quantity("head_angle_rms_deg", "head direction", "deg"),
    Quantity("head_position_rms_mm", "head position", "mm"),
)
_INSIDE = (
    Quantity("lip_landmarks_coverage_95", "lip landmarks in 95 %", SHARE),
    Quantity("lip_points_coverage_95", "lip points in 95 %", SHARE),
    Quantity("landmarks_coverage_95", "68 landmarks in 95 %", SHARE),
)
PRIMARY = (*_LIPS, *_MESH[:1], *_POINTS, *_PICTURE)
"""A system's worst frames are those with the largest of the first of these that it gives."""


def sureness_series(run: Mapping[str, NDArray[Any]]) -> dict[str, Series]:
    """Uncertainty of a run in each frame; see `SURENESS`.

    Parameters
    ----------
    run : mapping of str to (T,) array
        As `load_run` gives it.
    """
    half = {f"{k}_half": NORMAL_95 * run[f"{k}_sd"] for k in ("aperture", "width")
            if f"{k}_sd" in run}  # fmt: skip
    given = {k: run[k] for k in ("score", "landmark_distance") if k in run} | half
    known = {key: np.asarray(values, np.float64) for key, values in given.items()}
    return {key: Series(values) for key, values in known.items() if np.isfinite(values).any()}


def error_series(means: Mapping[str, Mean]) -> dict[str, Series]:
    """The errors of each frame behind the means of `abs_engine.evaluate.score.measure`."""
    wanted = [q.key for q in (*_LIPS, *_MESH, *_POINTS, *_PICTURE, *_POSE, *_INSIDE)]
    return {key: _series(means[key]) for key in wanted if key in means}


def error_rows(systems: Sequence[Mapping[str, Series]]) -> tuple[Quantity, ...]:
    """The quantities to draw for these systems, those first that most systems have.

    The landmarks of the lips; areas of the mesh rather than other points; the pose; and how often
    95 % intervals hold the truth.

    Parameters
    ----------
    systems : sequence of mapping of key to Series
        What `error_series` gave for each.
    """
    rows = list(_given(_MESH, systems))
    for group in (_POINTS[:2], _POINTS[2:]):
        without = [s for s in systems if not any(q.key in s for q in rows)]
        rows += _given(group, without)
    rows += _given(_PICTURE, [s for s in systems if not any(q.key in s for q in rows)])
    lips = _given(_LIPS[:1], systems)
    lips += _given(_LIPS[1:], [s for s in systems if not any(q.key in s for q in lips)])
    return (*lips, *rows, *_given(_POSE, systems), *_given(_INSIDE, systems))


def _given(
    quantities: Sequence[Quantity], systems: Sequence[Mapping[str, Series]]
) -> list[Quantity]:
    return [q for q in quantities if any(q.key in system for system in systems)]


def _series(mean: Mean) -> Series:
    known = mean.weight > 0
    values = np.full(len(mean), np.nan)
    values[known] = mean.part[known] / mean.weight[known]
    return Series(np.sqrt(values) if mean.root else values)
