"""Scores any system's estimate of a clip against its truth, by the same metrics on the same frames.

Each metric is first kept frame by frame (`Mean`), so that clips can be pooled and confidence
intervals drawn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.errors import ParameterError, PluginError
from abs_engine.core.foreign import blamed
from abs_engine.dataset import Truth
from abs_engine.evaluate import metrics
from abs_engine.evaluate.catalogue import added, catalogue
from abs_engine.evaluate.closing import Closures, closures, unsaid
from abs_engine.evaluate.derived_rows import complete
from abs_engine.evaluate.estimate import Estimate, places, within
from abs_engine.evaluate.landmark_coverage import given_landmarks
from abs_engine.evaluate.measures import (
    closure_means,
    curve_means,
    pixel_means,
    pose_means,
    track_means,
)
from abs_engine.evaluate.metrics.bootstrap import Mean, confidence, value
from abs_engine.evaluate.metrics.curves import landmark_curves
from abs_engine.evaluate.metrics.failure import LIMIT_MM, LIMIT_NORMALISED

PRIMARY = ("lip_landmarks", "lip_points", "lips", "landmarks", "face", "jaw")
"""The track by which frames fail: the landmarks of the lips, or what comes nearest to them."""


@dataclass(frozen=True)
class Score:
    """A number and its 95 % confidence interval; NaN where there is none."""

    value: float
    low: float = float("nan")
    high: float = float("nan")


@dataclass(frozen=True, eq=False)
class ClipScores:
    """The metrics of one clip, frame by frame, and those that are no means.

    Parameters
    ----------
    rate : float
        Frames per second.
    closures : two (T,) bool, optional
        Frames that are called closed, and those that are, see `closing.closures`.
    notes : tuple of str
        What a reader of the scores should know.
    """

    name: str
    rate: float
    means: dict[str, Mean]
    numbers: dict[str, float]
    closures: Closures | None = None
    notes: tuple[str, ...] = ()


def measure(estimate: Estimate, truth: Truth, landmark_68: NDArray[Any] | None) -> ClipScores:
    """All metrics of an estimate that it says enough for.

    Parameters
    ----------
    landmark_68 : (68,) int, optional
        The landmarks on the truth's mesh, for landmarks in the picture.

    Raises
    ------
    ParameterError
        If the estimate is of other frames or of another mesh than the truth.
    """
    check(estimate, truth)
    seen = in_picture(truth, landmark_68)
    said = _with_protrusion(within(complete(estimate, truth, landmark_68), seen), truth)
    means: dict[str, Mean] = {}
    errors: dict[str, FloatArray] = {}
    for name, track in said.tracks.items():
        if np.isfinite(track.points).all(axis=2).any():
            found, squared = track_means(name, track, said, truth)
            means |= found
            errors[name] = np.sqrt(squared)
    if said.pixels is not None and landmark_68 is not None:
        found, errors["pixels"] = pixel_means(said.pixels, truth, landmark_68)
        means |= found
    given = given_landmarks(said, estimate.pixels is not None, landmark_68)
    failed = _failed(said, errors)
    if given is not None:
        means |= given.means()
        failed = failed | given.failed
    means["failure_share"] = Mean.share(failed, seen)
    means |= pose_means(said, truth)
    numbers = {"frames": float(seen.sum()), "frames_lost": float((~said.found & seen).sum())}
    if said.curves_on == "rest" and landmark_68 is not None:
        rest = truth.neutral[landmark_68].astype(np.float64)
        true_curves = landmark_curves(truth.points(landmark_68), rest)
    else:
        true_curves = truth_curves(truth)
    for name, true in true_curves.items():
        if name in said.curves and np.isfinite(said.curves[name]).any():
            means |= curve_means(name, said.curves[name], true, said)
            numbers[f"{name}_correlation"] = metrics.correlation(said.curves[name], true)
    closed = closures(said, truth, true_curves["aperture"], landmark_68)
    if closed is not None:
        means |= closure_means(closed[0], closed[1] & seen, truth.rate, unsaid(said), ~seen)
    means |= _added_means(said, truth)
    notes = () if given is None else given.notes()
    return ClipScores(estimate.name, truth.rate, means, numbers, closed, notes)


def _added_means(said: Estimate, truth: Truth) -> dict[str, Mean]:
    """Means of the metrics that packages and plugins add, as far as the estimate allows them."""
    means = {}
    for metric in added():
        name = f"the metric '{metric.key}'"
        with blamed(name):
            values = np.asarray(metric.measure(said, truth), np.float64)  # type: ignore[misc]
        if values.shape != (len(truth),):
            raise PluginError(
                f"{name} returns values of shape {values.shape}",
                f"return one for each of the {len(truth)} frames",
            )
        known = values[~np.isnan(values)]
        if np.isinf(known).any():
            raise PluginError(
                f"{name} returns infinite values", "return NaN where there is nothing to measure"
            )
        if metric.root and (known < 0).any():
            raise PluginError(
                f"{name} takes the root of a mean below 0",
                "return squares, or leave out root=True",
            )
        if known.size:
            means[metric.key] = Mean.of(values, root=metric.root)
    return means


def in_picture(truth: Truth, landmark_68: NDArray[Any] | None) -> BoolArray:
    """Frames (T,) in which a landmark lies in the picture, hidden or not; the others do not count.

    Without landmarks all frames count.
    """
    if landmark_68 is None:
        return np.ones(len(truth), bool)
    points = metrics.to_camera(truth.points(landmark_68), truth.rotations, truth.translations)
    pixels, size = truth.camera.project(points), np.array(truth.camera.size)
    inside = ((pixels > -0.5) & (pixels < size - 0.5)).all(axis=2) & (points[..., 2] > 0)
    return np.asarray(inside.any(axis=1))


def check(estimate: Estimate, truth: Truth) -> None:
    """Raise `ParameterError` unless an estimate is of the truth's frames and mesh."""
    if len(estimate) != len(truth):
        raise ParameterError(
            f"{estimate.name} has {len(estimate)} frames, the truth {len(truth)}",
            "evaluate results for the frames of this very clip",
        )
    for track in estimate.tracks.values():
        vertex = track.vertex
        if len(vertex) == 0 or vertex.min() < 0 or vertex.max() >= len(truth.neutral):
            raise ParameterError(
                f"points of {estimate.name} are not among the truth's {len(truth.neutral)} "
                "vertices",
                "evaluate with the speaker that was filmed",
            )
    if not estimate.found.any():
        raise ParameterError(
            f"{estimate.name} has tracked no frame", "look at its overlay or its file"
        )


def summary(clips: Sequence[ClipScores], *, seed: int = 0) -> dict[str, Score]:
    """Scores over one clip, or pooled over several of one system, in the catalogue's order."""
    scores: dict[str, Score] = {}
    for metric in catalogue():
        given = [clip for clip in clips if metric.key in clip.means]
        means = [clip.means[metric.key] for clip in given]
        if means:
            low, high = confidence(means, [clip.rate for clip in given], seed=seed)
            scores[metric.key] = Score(value(means), low, high)
        numbers = [clip.numbers[metric.key] for clip in clips if metric.key in clip.numbers]
        if numbers:
            known = [n for n in numbers if not np.isnan(n)]  # as of constant curves' correlation
            mean = float(np.mean(known)) if known else float("nan")
            scores[metric.key] = Score(sum(numbers) if metric.key.startswith("frames") else mean)
    return scores


def truth_curves(truth: Truth) -> dict[str, FloatArray]:
    """The true lip curves (T,), mm, see `metrics.lip_curves`."""
    curves = {"aperture": truth.aperture, "width": truth.width}
    if "outer_lip_20" in truth.landmarks:
        outer = truth.points(truth.landmarks["outer_lip_20"][[3, 9]])
        curves["protrusion"] = outer[:, :, 2].mean(axis=1)
    return curves


def error_map(estimate: Estimate, truth: Truth) -> FloatArray:
    """RMS error of every vertex over the tracked frames, (V,) mm, head frame.

    NaN for vertices of which the estimate says nothing.
    """
    out = np.full(len(truth.neutral), np.nan)
    if estimate.surface is not None:
        squares, count = np.zeros(len(out)), 0
        for frame in np.flatnonzero(estimate.found).tolist():
            away = estimate.surface.vertices(frame) - truth.vertices(frame)
            squares += (away**2).sum(axis=1)
            count += 1
        return np.asarray(np.sqrt(squares / max(count, 1)))
    for track in estimate.tracks.values():
        if track.space == "head":
            out[track.vertex] = metrics.vertex_rms(track.points, truth.points(track.vertex))
    return out


def _with_protrusion(said: Estimate, truth: Truth) -> Estimate:
    """The estimate with its protrusion, where it gives the points 51 and 57 in head coordinates."""
    if "protrusion" in said.curves or "outer_lip_20" not in truth.landmarks:
        return said
    middle = truth.landmarks["outer_lip_20"][[3, 9]]
    for track in said.tracks.values():
        at = places(middle, track.vertex)
        if track.space == "head" and at is not None:
            lips = track.points[:, at, 2]
            return replace(said, curves={**said.curves, "protrusion": lips.mean(axis=1)})
    return said


def _failed(estimate: Estimate, errors: dict[str, FloatArray]) -> BoolArray:
    for name in PRIMARY:
        if name in errors:
            return metrics.failed(np.where(estimate.found, errors[name], np.nan), LIMIT_MM)
    if "pixels" in errors:
        error = np.where(estimate.found, errors["pixels"], np.nan)
        return metrics.failed(error, LIMIT_NORMALISED)
    return np.asarray(~estimate.found)
