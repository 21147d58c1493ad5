"""A run whose curves are smoothed before it is exported; the run itself stays as it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.geometry import FACING, Pose
from abs_engine.export.exporter import Loss, TrackedRun, rms
from abs_engine.tracking.measures import closure_arrays, closures, cuts
from abs_engine.tracking.run_table import closed_frames
from abs_engine.tracking.smoothing import Smoothing


def smoothed(run: TrackedRun, smoothing: Smoothing) -> tuple[TrackedRun, Loss]:
    """Postures, the head's pose and all measures smoothed; and how far this moves the lips.

    Raises
    ------
    ParameterError
        If the filter cannot be used for the run's frames.
    """
    time = np.asarray(run.arrays["time"], np.float64)
    smoothing.check(run.rate, time)
    cut = cuts(run.arrays)
    mesh = replace(run.mesh, weights=smoothing(run.mesh.weights, run.rate, cut))
    measured = smoothing.measures(run.arrays)
    rotation, translation = _poses(run, smoothing)
    arrays = {
        **run.arrays, **measured, "rotation": rotation, "translation": translation,
        "parameters": smoothing(run.arrays["parameters"], run.rate, cut),
        "closed": closed_frames(measured["aperture"]),
        **closure_arrays(closures(measured["aperture"], time, cut)),
    }  # fmt: skip
    lips = run.speaker.points["lips"]
    moved = Loss(rms(mesh.points(lips) - run.mesh.points(lips)), "mm", f"lips, by {smoothing}")
    return replace(run, arrays=arrays, mesh=mesh), moved


def _poses(run: TrackedRun, smoothing: Smoothing) -> tuple[FloatArray, FloatArray]:
    """Rotation vectors and translations (T, 3); smoothed about the pose that faces the camera.

    There rotation vectors do not jump, as those of a face that looks into the camera do.
    """
    turned = np.full((len(run), 3), np.nan)
    there = np.isfinite(run.arrays["rotation"]).all(axis=1)
    posed = np.flatnonzero(there).tolist()  # frames with a covered mouth among them
    for frame in posed:
        turned[frame] = Pose(FACING.T @ run.pose(frame).rotation, np.zeros(3)).rotation_vector
    cut = cuts(run.arrays)
    turned = smoothing(turned, run.rate, cut)
    rotation = np.full((len(run), 3), np.nan)
    for frame in posed:
        about = Pose.from_vectors(turned[frame], np.zeros(3)).rotation
        rotation[frame] = Pose(FACING @ about, np.zeros(3)).rotation_vector
    return rotation, smoothing(run.arrays["translation"], run.rate, cut)
