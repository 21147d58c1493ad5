"""The catalogue of a score's numbers: meaning, unit, and definition of each."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from abs_engine.core.errors import PluginError
from abs_engine.core.registry import METRICS
from abs_engine.dataset import Truth
from abs_engine.dataset.codec import CLOSED_BELOW
from abs_engine.evaluate.estimate import Estimate
from abs_engine.io.assets import CLOSED_APERTURE

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Metric:
    """A number of a score.

    Parameters
    ----------
    key : str
        Its name in ``scores.json``.
    label : str
        Its row in the table.
    unit : str
        A "share" is shown in percent.
    definition : str
        What is computed; the functions of `abs_engine.evaluate.metrics` cite their sources.
    measure : callable, optional
        Of a metric that is added to `abs_engine.METRICS`: given the estimate and the truth, returns
        its (T,) values, whose mean is the score; NaN in frames that do not count.
    root : bool
        Whether the score is the square root of their mean.
    """

    key: str
    label: str
    unit: str
    definition: str
    measure: Callable[[Estimate, Truth], NDArray[Any]] | None = None
    root: bool = False


TRACKS = {
    "lip_points": "lip points",
    "landmarks": "68 landmarks",
    "lip_landmarks": "lip landmarks",
    "face": "face",
    "lips": "lips",
    "jaw": "jaw",
}
WHICH = {
    "lip_points": ", of the points of the lips that a run of this engine gives",
    "landmarks": ", in each frame of those of the 68 points that the system gives there",
    "lip_landmarks": ", of points 48 to 67",
}
"""Points of a track that its name does not say."""

CURVES = ("aperture", "width", "protrusion")


def _points(track: str, name: str) -> list[Metric]:
    sure = f"root mean square of the distance to the truth{WHICH.get(track, '')}"
    return [
        Metric(f"{track}_rms_head_mm", f"{name}, head coordinates, RMS", "mm", sure),
        Metric(
            f"{track}_rms_head_offset_removed_mm",
            "  the same, one constant rigid offset removed",
            "mm",
            f"{sure}, after the one rigid motion of the whole clip that brings it closest (Kabsch)",
        ),
        Metric(f"{track}_rms_camera_mm", f"{name}, camera coordinates, RMS", "mm", sure),
        Metric(
            f"{track}_jitter_mm", f"{name}, jitter", "mm",
            "RMS of the error's second difference over sqrt(6): the size of frame-to-frame noise "
            "(Gasser et al. 1986); head coordinates, or the camera's where there is no head pose",
        ),
        Metric(
            f"{track}_acceleration_mm_s2", f"{name}, acceleration error", "mm/s2",
            "mean size of the error's second derivative (Kanazawa et al. 2019)",
        ),
        Metric(
            f"{track}_coverage_95", f"{name}, truth inside of 95 % intervals", "share",
            "share of coordinates that lie in the interval given for them",
        ),
    ]  # fmt: skip


def _curve(key: str) -> list[Metric]:
    return [
        Metric(f"{key}_rms_mm", f"{key}, RMS", "mm", "root mean square difference"),
        Metric(f"{key}_bias_mm", f"{key}, bias", "mm", "mean difference, estimate - truth"),
        Metric(
            f"{key}_correlation", f"{key}, correlation", "",
            "Pearson's, over frames; of several clips, the mean over those that have one",
        ),
        Metric(
            f"{key}_coverage_95", f"{key}, truth inside of 95 % intervals", "share",
            "share of frames in which the true value lies in the interval given for it",
        ),
    ]  # fmt: skip


CLOSURE = (
    f". Closed is an aperture (points 62 and 66) below {CLOSED_APERTURE:g} mm, of every system and "
    "of the truth, measured alike: on the mesh, on landmarks in mm after the stable ones are laid "
    "on the person at rest, or in the picture with the distance of the eyes as the ruler. Of a "
    "system that gives none of them, what it says itself, against frames of the truth whose widest "
    f"gap between the lips is below {CLOSED_BELOW} mm"
)

VISIBLE = (
    ", as `landmark_visible` of the truth says: in the picture with nothing before them, or in a "
    "fold of the lips that is seen within 1.5 mm"
)

BUILT_IN: tuple[Metric, ...] = (
    Metric(
        "frames", "frames", "",
        "frames of the truth with the face in the picture; the others do not count",
    ),
    Metric("frames_lost", "frames lost", "", "frames in which the system gave nothing"),
    Metric(
        "failure_share", "frames that failed", "share",
        "lost, or RMS error of the lip landmarks 48 to 67 above 5 mm, in head coordinates, or in "
        "the camera's where the system gives no head pose; where it gives no 3D, their mean error "
        "in the picture above 0.08 of the distance of the eyes (Shen et al. 2015). Of a system "
        "that lacks some of these landmarks, the error of the points that it gives. A frame that "
        "lacks a lip landmark, or more than half of the landmarks, that the system gives in other "
        "frames failed, too",
    ),
    Metric(
        "landmarks_given", "68 landmarks given", "share",
        "mean over tracked frames of the share that is given, of those landmarks that the system "
        "gives in any frame",
    ),
    Metric("lips_given", "lip landmarks given", "share", "the same for points 48 to 67"),
    *(metric for track, name in TRACKS.items() for metric in _points(track, name)),
    Metric(
        "landmarks_rms_px", "68 landmarks, picture, RMS", "px",
        "root mean square of the distance; of a system that gives no pixels, the landmarks in "
        "camera coordinates are projected by the true camera",
    ),
    Metric(
        "landmarks_visible_rms_px", "68 landmarks that are seen, picture, RMS", "px",
        f"the same over the points that the camera sees in each frame{VISIBLE}",
    ),
    Metric(
        "landmarks_nme", "68 landmarks, over distance of eyes", "share",
        "mean distance over the true distance of points 36 and 45 (Sagonas et al. 2016)",
    ),
    Metric("lips_rms_px", "lip landmarks, picture, RMS", "px", "the same for points 48 to 67"),
    Metric(
        "lips_visible_rms_px", "lip landmarks that are seen, picture, RMS", "px",
        f"for those of points 48 to 67 that the camera sees in each frame{VISIBLE}",
    ),
    Metric("lips_nme", "lip landmarks, over distance of eyes", "share", "for points 48 to 67"),
    *(metric for key in CURVES for metric in _curve(key)),
    Metric(
        "closure_precision_frames", "closed frames, precision", "share",
        f"share of the frames called closed that are{CLOSURE}",
    ),
    Metric(
        "closure_recall_frames", "closed frames, recall", "share",
        f"share of the closed frames that are called so{CLOSURE}",
    ),
    Metric(
        "closure_precision_events", "closures, precision", "share",
        "share of the runs of frames called closed that overlap with a closure, one to one; frames "
        "within a closure that are lost, or lack what it is measured on, do not divide a run",
    ),
    Metric(
        "closure_recall_events", "closures, recall", "share",
        "share of the closures that overlap with a run of frames called closed, one to one",
    ),
    Metric(
        "closure_onset_error_ms", "closure onset, mean error", "ms",
        "mean size of the difference of onsets (times of the first closed frames; closures.csv has "
        "moments between frames), over closures found, but for those at a clip's "
        "first frame, or after one that is lost, lacks what it is measured on, or is without the "
        "head",
    ),
    Metric(
        "closure_onset_bias_ms", "closure onset, bias", "ms",
        "mean difference of onsets; positive: late",
    ),
    Metric(
        "head_angle_rms_deg", "head direction, RMS", "deg",
        "root mean square of the geodesic angle (Huynh 2009)",
    ),
    Metric(
        "head_angle_offset_removed_rms_deg", "  the same, one constant turn removed", "deg",
        "after the one constant turn that brings the clip closest (Hartley et al. 2013)",
    ),
    Metric(
        "head_position_rms_mm", "head position, RMS", "mm",
        "root mean square distance of the head's origin in camera coordinates",
    ),
)  # fmt: skip
BY_KEY = {metric.key: metric for metric in BUILT_IN}


def added() -> tuple[Metric, ...]:
    """Metrics of installed packages and plugins, those left out that cannot be imported.

    Raises
    ------
    PluginError
        If one has a key of the engine's own, whose scores it would replace, or a key other than the
        name that it was added under; names are unique.
    """
    metrics: dict[str, Metric] = METRICS.working()[0]
    for name, metric in metrics.items():
        if metric.key in BY_KEY:
            raise PluginError(
                f"the engine already has a metric '{metric.key}'", "give yours another key"
            )
        if metric.key != name:
            raise PluginError(
                f"the metric '{name}' has the key '{metric.key}'", "add it under its key"
            )
    return tuple(metrics.values())


def warn_of_faults() -> None:
    """Log a warning for each metric that cannot be imported, and is left out."""
    for fault in METRICS.working()[1].values():
        _log.warning("warning: %s", fault)


def catalogue() -> tuple[Metric, ...]:
    """All metrics in the order of a table's rows."""
    return BUILT_IN + added()
