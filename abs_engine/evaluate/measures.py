"""The metrics of one estimate and one clip, each kept frame by frame."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray, IntArray
from abs_engine.dataset import Truth
from abs_engine.dataset.codec import POINTS
from abs_engine.evaluate import metrics
from abs_engine.evaluate.estimate import Estimate, PointTrack
from abs_engine.evaluate.metrics.bootstrap import Mean
from abs_engine.io.assets import LIPS_OF_68


def track_means(
    name: str, track: PointTrack, estimate: Estimate, truth: Truth
) -> tuple[dict[str, Mean], FloatArray]:
    """Metrics of a track, and the squared error of each frame in its best frame of reference."""
    true = truth.points(track.vertex)
    true_in_camera = metrics.to_camera(true, truth.rotations, truth.translations)
    head, camera = both_spaces(track, estimate)
    means: dict[str, Mean] = {}
    if head is not None:
        aligned = metrics.without_constant_offset(head, true)
        means[f"{name}_rms_head_mm"] = _rms(metrics.squared_distance(head, true))
        means[f"{name}_rms_head_offset_removed_mm"] = _rms(metrics.squared_distance(aligned, true))
    if camera is not None:
        means[f"{name}_rms_camera_mm"] = _rms(metrics.squared_distance(camera, true_in_camera))
    found, fair = (head, true) if head is not None else (camera, true_in_camera)
    if found is None:
        return means, np.full(len(truth), np.nan)
    means[f"{name}_jitter_mm"] = _rms(metrics.noise_level(found, fair))
    shake = metrics.acceleration_error(found, fair, truth.rate)
    means[f"{name}_acceleration_mm_s2"] = Mean.of(shake)
    if name in estimate.intervals:
        means[f"{name}_coverage_95"] = Mean.of(metrics.covered(*estimate.intervals[name], true))
    return means, metrics.squared_distance(found, fair)


def pixel_means(
    pixels: FloatArray, truth: Truth, landmark_68: NDArray[Any]
) -> tuple[dict[str, Mean], FloatArray]:
    """Metrics of landmarks in the picture, and the normalised error of the lips in each frame.

    Of all landmarks where the system gives none of the lips.
    """
    true = true_pixels(truth, landmark_68)
    eyes = metrics.interocular(true)
    error = metrics.normalised_error(pixels, true, eyes)
    means = {
        "landmarks_rms_px": _rms(metrics.pixel_error(pixels, true)),
        "landmarks_nme": Mean.of(error),
    }
    lips, true_lips = pixels[:, LIPS_OF_68], true[:, LIPS_OF_68]
    means["lips_rms_px"] = _rms(metrics.pixel_error(lips, true_lips))
    lip_error = metrics.normalised_error(lips, true_lips, eyes)
    means["lips_nme"] = Mean.of(lip_error)
    hidden = hidden_landmarks(truth, landmark_68)
    if hidden is not None:
        shown = np.where(hidden[..., None], np.nan, pixels)
        means["landmarks_visible_rms_px"] = _rms(metrics.pixel_error(shown, true))
        lips = shown[:, LIPS_OF_68]
        means["lips_visible_rms_px"] = _rms(metrics.pixel_error(lips, true_lips))
    return means, lip_error if np.isfinite(lip_error).any() else error


def hidden_landmarks(truth: Truth, landmark_68: NDArray[Any]) -> BoolArray | None:
    """Mask (T, 68) of the landmarks hidden from the camera; None where that is not known."""
    told = truth.landmarks.get("landmark_68")
    if not np.array_equal([] if told is None else told, landmark_68):
        return None
    if not (truth.folder / POINTS).is_file():
        return None
    return np.asarray(~truth.landmark_visible)


def pose_means(estimate: Estimate, truth: Truth) -> dict[str, Mean]:
    """Errors of the head's direction and position, as far as the system gives them."""
    means: dict[str, Mean] = {}
    if estimate.rotations is not None:
        angle = metrics.head_angle_without_offset(
            estimate.rotations, truth.rotations, estimate.turned
        )
        means["head_angle_offset_removed_rms_deg"] = _rms(angle**2)
        if estimate.turned == "head":
            plain = metrics.head_angle(estimate.rotations, truth.rotations)
            means["head_angle_rms_deg"] = _rms(plain**2)
    if estimate.translations is not None:
        away = metrics.head_distance(estimate.translations, truth.translations)
        means["head_position_rms_mm"] = _rms(away**2)
    return means


def curve_means(
    name: str, found: FloatArray, true: FloatArray, estimate: Estimate
) -> dict[str, Mean]:
    """RMS, bias and coverage of a lip curve."""
    means = {f"{name}_rms_mm": _rms((found - true) ** 2), f"{name}_bias_mm": Mean.of(found - true)}
    if name in estimate.intervals:
        means[f"{name}_coverage_95"] = Mean.of(metrics.covered(*estimate.intervals[name], true))
    return means


def closure_means(
    found: BoolArray, true: BoolArray, rate: float, lost: BoolArray, unseen: BoolArray
) -> dict[str, Mean]:
    """Frames, events and onsets of closures; an event counts in the frame in which it begins."""
    events = metrics.closure_events(found, true, lost, unseen)
    hits = events.found[events.pairs[:, 0], 0], events.true[events.pairs[:, 1], 0]
    begun = events.found[:, 0], events.true[:, 0]
    late = np.full(len(true), np.nan)
    late[events.onsets[:, 1]] = (events.onsets[:, 0] - events.onsets[:, 1]) * 1000.0 / rate
    return {
        "closure_precision_frames": Mean.share(true, found),
        "closure_recall_frames": Mean.share(found, true),
        "closure_precision_events": Mean.share(*(_at(k[0], len(true)) for k in (hits, begun))),
        "closure_recall_events": Mean.share(*(_at(k[1], len(true)) for k in (hits, begun))),
        "closure_onset_error_ms": Mean.of(np.abs(late)),
        "closure_onset_bias_ms": Mean.of(late),
    }


def true_pixels(truth: Truth, vertex: NDArray[Any]) -> FloatArray:
    """Places of vertices (N,) in the picture in every frame, (T, N, 2), seen or not."""
    points = metrics.to_camera(truth.points(vertex), truth.rotations, truth.translations)
    return truth.camera.project(points)


def both_spaces(
    track: PointTrack, estimate: Estimate
) -> tuple[FloatArray | None, FloatArray | None]:
    """A track in head and in camera coordinates, as far as the system's own pose allows it."""
    pose = estimate.rotations, estimate.translations
    if pose[0] is None or pose[1] is None:
        return (track.points, None) if track.space == "head" else (None, track.points)
    if track.space == "head":
        return track.points, metrics.to_camera(track.points, pose[0], pose[1])
    return metrics.to_head(track.points, pose[0], pose[1]), track.points


def _at(frames: IntArray, count: int) -> BoolArray:
    flags = np.zeros(count, bool)
    flags[frames] = True
    return flags


def _rms(squares: FloatArray) -> Mean:
    return Mean.of(squares, root=True)
