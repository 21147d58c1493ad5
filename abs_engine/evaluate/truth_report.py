"""A run against its ground truth: a table of numbers, and a picture of the curves."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from abs_engine.core.errors import OutputError
from abs_engine.core.kinds import check_kind, is_of, to_path
from abs_engine.dataset import Truth, load_truth
from abs_engine.evaluate.closing import Closures, narrow
from abs_engine.evaluate.estimate import check_run
from abs_engine.evaluate.metrics import (
    PointError,
    closure,
    curve_error,
    head_angle,
    head_distance,
    lip_rms_mm,
    spikes,
    to_camera,
    without_constant_offset,
)
from abs_engine.tracking.record import load_run

RunArrays = Mapping[str, NDArray[Any]]


class Tracked(Protocol):
    """A run that holds its arrays."""

    @property
    def arrays(self) -> RunArrays:
        """Arrays of a run by their names."""
        ...


SPIKE = 3.0
"""Millimetres by which an aperture must stand out from both neighbours to be a spike."""

SCORES, CURVES = "truth_scores.json", "truth_curves.png"


def report(
    run: RunArrays, truth: Truth, folder: Path, closures: Closures | None = None
) -> dict[str, Any]:
    """Score a run and write ``truth_scores.json`` and ``truth_curves.png`` into `folder`.

    Parameters
    ----------
    run : mapping of str to array
        See `score`.
    truth : Truth
    folder : Path
        Must exist.
    closures : two (T,) bool, optional
        See `score`.

    Returns
    -------
    dict
        What `score` returns.

    Raises
    ------
    InputFileError, ParameterError
        As `score`.
    OutputError
        If the folder cannot be written.
    """
    scores = score(run, truth, closures)
    try:
        text = json.dumps(_plain(scores), indent=1, allow_nan=False) + "\n"
        (Path(folder) / SCORES).write_text(text, encoding="utf-8")
        draw(run, truth).savefig(Path(folder) / CURVES, dpi=100)
    except OSError as error:
        raise OutputError(
            f"{folder} cannot be written ({error.strerror})", "name a folder that you may write to"
        ) from error
    return scores


def score(
    run: RunArrays | Tracked | Path | str,
    truth: Truth | Path | str,
    closures: Closures | None = None,
) -> dict[str, Any]:
    """Numbers of a run against the truth.

    Parameters
    ----------
    run : mapping of str to array, an object with one as `arrays`, or the path of a run
        `lip_points` (T, N, 3), mm, head frame; `lip_vertex` (N,), their vertex indices in the
        truth's mesh; `rotation` (T, 3), rotation vectors, and `translation` (T, 3), mm, head
        to camera; `aperture` and `width` (T,), mm, defined as `Truth.aperture` and `Truth.width`.
        What it says itself of closed lips does not count.
    truth : Truth, or its path
    closures : two (T,) bool, optional
        Frames that are called closed, and those that are, as measured on the meshes; by default
        those in which the aperture, the run's and the truth's, is below `CLOSED_APERTURE`.

    Returns
    -------
    dict
        ``lip_rms_head_raw_mm`` (head coordinates, no alignment),
        ``lip_rms_head_offset_removed_mm`` (after one rigid motion for the whole clip, see
        `without_constant_offset`), ``lip_rms_camera_mm``, ``head_angle_rms_deg``,
        ``head_position_rms_mm``, ``aperture``, ``width`` (rms, bias, correlation), ``closure``
        (precision, recall, in frames), ``aperture_spikes``, ``frames``, ``frames_tracked``.

    Raises
    ------
    InputFileError
        If the run lacks an array, or a path leads to no run or truth.
    ParameterError
        If the run is of other frames or of another mesh than the truth, or a value is of another
        kind.
    """
    run = _arrays(run)
    truth = truth if isinstance(truth, Truth) else load_truth(to_path("truth", truth))
    check_run(run, len(truth), len(truth.neutral))
    found, vertex = run["lip_points"], run["lip_vertex"]
    true = truth.points(vertex)
    in_camera = to_camera(found, run["rotation"], run["translation"])
    true_in_camera = to_camera(true, truth.rotations, truth.translations)
    tracked = np.asarray(np.isfinite(found).all(axis=(1, 2)))
    if closures is None:
        closures = narrow(run["aperture"]), narrow(truth.aperture)
    return {
        "frames": len(truth),
        "frames_tracked": int(tracked.sum()),
        "lip_points": len(vertex),
        "lip_rms_head_raw_mm": lip_rms_mm(found, true).overall,
        "lip_rms_head_offset_removed_mm": _aligned(run, truth).overall,
        "lip_rms_camera_mm": lip_rms_mm(in_camera, true_in_camera).overall,
        **_pose_error(run, truth, tracked),
        "aperture": asdict(curve_error(run["aperture"], truth.aperture)),
        "width": asdict(curve_error(run["width"], truth.width)),
        "closure": asdict(closure(*closures)),
        "aperture_spikes": spikes(run["aperture"], SPIKE),
    }


def _arrays(run: RunArrays | Tracked | Path | str) -> RunArrays:
    if isinstance(run, str | Path):
        return load_run(Path(run))
    arrays: Any = getattr(run, "arrays", run)
    check_kind("run", arrays, (is_of(Mapping), "a run, its arrays, or its path"))
    return dict(arrays)


def draw(run: RunArrays, truth: Truth) -> Figure:
    """Curves of aperture, width and lip error over time; closed frames of the truth are shaded."""
    figure = Figure(figsize=(9, 7.5), layout="constrained")
    top, middle, bottom = figure.subplots(3, 1, sharex=True)
    seconds = np.arange(len(truth)) / truth.rate
    for axes, name, true in ((top, "aperture", truth.aperture), (middle, "width", truth.width)):
        axes.plot(seconds, true, color="black", label="truth")
        axes.plot(seconds, run[name], color="tab:red", label="tracked")
        axes.set_ylabel(f"lip {name} (mm)")
        _above(axes)
    raw = lip_rms_mm(run["lip_points"], truth.points(run["lip_vertex"]))
    for error, label in ((raw, "raw"), (_aligned(run, truth), "constant rigid offset removed")):
        line = f"{label}: {error.overall:.2f} mm"
        bottom.plot(seconds, error.per_frame, label=line)
    bottom.set(ylabel="lip points, RMS\n(mm, head frame)", xlabel="time (s)", ylim=(0, None))
    _above(bottom)
    half = 0.5 / truth.rate
    for axes in (top, middle, bottom):
        for at in seconds[truth.closed]:
            axes.axvspan(at - half, at + half, color="0.9", lw=0)
    figure.suptitle(f"{truth.person}: {truth.sentence} (shaded: lips closed)")
    return figure


def _above(axes: Axes) -> None:
    """Put a legend where it hides no curve: in one line above its axes, on the right."""
    place = (1.0, 1.0)
    axes.legend(loc="lower right", bbox_to_anchor=place, borderaxespad=0.2, ncols=2, frameon=False)


def _aligned(run: RunArrays, truth: Truth) -> PointError:
    true = truth.points(run["lip_vertex"])
    return lip_rms_mm(without_constant_offset(run["lip_points"], true), true)


def _pose_error(run: RunArrays, truth: Truth, tracked: NDArray[np.bool_]) -> dict[str, float]:
    """Root mean square over frames of the angle between poses, and of their distance."""
    angle = head_angle(run["rotation"], truth.rotations)
    away = head_distance(run["translation"], truth.translations)
    return {"head_angle_rms_deg": _rms(angle[tracked]), "head_position_rms_mm": _rms(away[tracked])}


def _rms(values: NDArray[np.float64]) -> float:
    return float(np.sqrt((values**2).mean()))


def _plain(value: Any) -> Any:
    """The same value with null where it is NaN, as JSON has no NaN."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    return None if isinstance(value, float) and math.isnan(value) else value
