"""One estimate's part of a report: curves, lips in the picture, a head in motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.dataset import Truth
from abs_engine.evaluate import metrics
from abs_engine.evaluate.estimate import Estimate
from abs_engine.io.assets import Speaker
from abs_engine.report.data import Head, Series, System
from abs_engine.report.motion import compress
from abs_engine.report.scoring import same_mesh
from abs_engine.tracking.results.run_mesh import LinearSurface

Loops = Mapping[str, NDArray[np.int32]]
_MANY_MODES = 16


def system_of(estimate: Estimate, camera: Camera, loops: Loops, played: int) -> System:
    """Report's view of an estimate, without any truth."""
    return System(
        estimate.name,
        curves={name: _curve(estimate, name) for name in estimate.curves},
        contours=contours_of(estimate, camera, loops),
        head=_head(estimate, played),
    )


def _curve(estimate: Estimate, name: str) -> Series:
    """A lip curve with its interval; no aperture is below 0."""
    low, high = estimate.intervals.get(name, (None, None))
    if low is not None and name == "aperture":
        low = np.maximum(low, 0)
    return Series(estimate.curves[name], low, high)


def _head(estimate: Estimate, played: int) -> Head | None:
    surface = estimate.surface
    if surface is None:
        return None
    motion = LinearSurface(
        np.asarray(surface.mean, np.float32),
        np.asarray(surface.modes, np.float32),
        np.asarray(surface.weights[:played], np.float32),
    )
    if len(motion.modes) > _MANY_MODES:
        motion = compress(motion.vertices, played)
    posed = estimate.turned == "head"
    return Head(
        motion, estimate.rotations if posed else None, estimate.translations if posed else None
    )


def contours_of(estimate: Estimate, camera: Camera, loops: Loops) -> dict[str, FloatArray]:
    """The lips in the picture: of the mesh, or of the landmarks 48 to 67."""
    turns, shifts = estimate.rotations, estimate.translations
    known = estimate.surface is not None and estimate.turned == "head"
    if known and turns is not None and shifts is not None:
        return projected(estimate.surface, turns, shifts, camera, loops)
    if estimate.pixels is not None:
        return {"outer": estimate.pixels[:, 48:60], "inner": estimate.pixels[:, 60:68]}
    return {}


def projected(
    surface: Any, turns: FloatArray, shifts: FloatArray, camera: Camera, loops: Loops
) -> dict[str, FloatArray]:
    """Vertices of a head in the picture, (T, N, 2) px for each loop; NaN in lost frames."""
    out = {}
    for name, loop in loops.items():
        points = surface.points(loop)
        found = np.isfinite(points).all(axis=(1, 2)) & np.isfinite(turns).all(axis=1)
        pixels = np.full((*points.shape[:2], 2), np.nan)
        seen = metrics.to_camera(points[found], turns[found], shifts[found])
        pixels[found] = camera.project(seen)
        out[name] = pixels
    return out


def with_protrusion(estimate: Estimate, lists: Loops) -> Estimate:
    """The estimate with the protrusion of its mesh, if it has a mesh and does not say itself."""
    if estimate.surface is None or "protrusion" in estimate.curves or "outer_lip_20" not in lists:
        return estimate
    outer, inner = (estimate.surface.points(lists[k]) for k in ("outer_lip_20", "inner_lip_8"))
    protrusion = metrics.lip_curves(outer, inner)["protrusion"]
    return replace(estimate, curves={**estimate.curves, "protrusion": protrusion})


def lip_loops(truth: Truth, speaker: Speaker) -> Loops:
    """Closed contours of the lips on the truth's mesh: fine where it is the bundled head's."""
    if same_mesh(truth, speaker):
        return speaker_loops(speaker)
    return {"outer": truth.landmarks["outer_lip"], "inner": truth.landmarks["inner_lip_8"]}


def speaker_loops(speaker: Speaker) -> Loops:
    """Closed contours `outer` and `inner` of the bundled head's lips, vertex indices."""
    upper, lower = (speaker.landmarks[f"inner_lip_{k}"] for k in ("upper", "lower"))
    inner = np.concatenate([upper, lower[-2:0:-1]])
    return {"outer": speaker.lip_ring, "inner": inner.astype(np.int32)}
