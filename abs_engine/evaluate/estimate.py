"""A system's estimate of the frames of a clip, whatever the system: the input of `score`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.errors import InputFileError, ModelFormatError, ParameterError
from abs_engine.io.arrays import Layout, check_arrays, of_json, real, whole
from abs_engine.io.assets import CLOSED_APERTURE
from abs_engine.tracking.results.run_mesh import LinearSurface

Areas = Mapping[str, NDArray[np.int32]]

NORMAL_95 = 1.959963984540054
"""Half the width of a normal distribution's central 95 %, in standard deviations."""

ClosedBy = Literal["own", "aperture", "picture"]


@dataclass(frozen=True, eq=False)
class PointTrack:
    """Points over time.

    Parameters
    ----------
    vertex : (N,) int, indices of the truth's vertices
    points : (T, N, 3) float64, mm
        NaN in lost frames, and for points that a frame does not give.
    space : {"head", "camera"}
        The frame of reference.
    """

    vertex: NDArray[np.integer[Any]]
    points: FloatArray
    space: Literal["head", "camera"] = "head"


def places(wanted: NDArray[Any], among: NDArray[Any]) -> list[int] | None:
    """Places of some vertices (N,) among others (M,); None if one of them is not there."""
    at = {int(vertex): k for k, vertex in enumerate(among)}
    found = [at.get(int(vertex)) for vertex in wanted]
    return [k for k in found if k is not None] if None not in found else None


@dataclass(frozen=True, eq=False)
class Estimate:
    """Results of a system for the T frames of a clip. A missing quantity is None or absent.

    Parameters
    ----------
    found : (T,) bool
        False in frames that the system gave up.
    tracks : mapping of str to PointTrack
        `lip_points`, `landmarks`, `lip_landmarks`, and the areas `face`, `lips` and `jaw`.
    rotations : (T, 3) float64, optional
        Rotation vectors, head to camera, radians.
    translations : (T, 3) float64, optional
        mm, head to camera.
    turned : {"head", "camera"}
        Which side of the rotations is in the system's own axes, see `head_angle_without_offset`.
    curves : mapping of str to (T,) float64, mm
        `aperture`, `width`, `protrusion`, as `metrics.lip_curves`.
    curves_on : {"axes", "rest"}
        Measured along the axes of the head frame, or after the stable landmarks of each frame were
        laid on the person at rest (`landmark_curves`); the truth's are then measured so, too.
    closed : (T,) bool, optional
    closed_by : {"own", "aperture", "picture"}
        Whether `closed` is the system's own word, or measured on its aperture, or on its landmarks
        in the picture; see `closing.closures`.
    pixels : (T, 68, 2) float64, optional
        Landmarks in the picture; NaN for points that are not given.
    intervals : mapping of str to (lower, upper)
        95 % intervals of a curve or of a track's points, of the same shape.
    surface : LinearSurface, optional
        The whole mesh, for error maps.
    """

    name: str
    found: BoolArray
    tracks: Mapping[str, PointTrack] = field(default_factory=dict)
    rotations: FloatArray | None = None
    translations: FloatArray | None = None
    turned: Literal["head", "camera"] = "head"
    curves: Mapping[str, FloatArray] = field(default_factory=dict)
    curves_on: Literal["axes", "rest"] = "axes"
    closed: BoolArray | None = None
    closed_by: ClosedBy = "own"
    pixels: FloatArray | None = None
    intervals: Mapping[str, tuple[FloatArray, FloatArray]] = field(default_factory=dict)
    surface: LinearSurface | None = None

    def __len__(self) -> int:
        """Return the number of frames, T."""
        return len(self.found)


def within(estimate: Estimate, seen: BoolArray) -> Estimate:
    """The estimate with nothing said about frames outside of `seen` (T,)."""

    def cut(values: FloatArray) -> FloatArray:
        return np.where(seen.reshape(-1, *[1] * (values.ndim - 1)), values, np.nan)

    def cut_or_none(values: FloatArray | None) -> FloatArray | None:
        return None if values is None else cut(values)

    return replace(
        estimate,
        found=estimate.found & seen,
        tracks={k: replace(v, points=cut(v.points)) for k, v in estimate.tracks.items()},
        rotations=cut_or_none(estimate.rotations),
        translations=cut_or_none(estimate.translations),
        curves={k: cut(v) for k, v in estimate.curves.items()},
        closed=None if estimate.closed is None else estimate.closed & seen,
        pixels=cut_or_none(estimate.pixels),
        intervals={k: (cut(low), cut(high)) for k, (low, high) in estimate.intervals.items()},
    )


RUN_KEYS = ("lip_points", "lip_vertex", "rotation", "translation", "aperture", "width")


_LAYOUT: Layout = {
    "lip_points": real("T", "N", 3, gaps=True),
    "lip_vertex": whole("N"),
    **dict.fromkeys(("rotation", "translation"), real("T", 3, gaps=True)),
    **dict.fromkeys(("aperture", "width"), real("T", gaps=True)),
}


def run_arrays(given: Mapping[str, ArrayLike]) -> dict[str, NDArray[Any]]:
    """Arrays of a run that was made in memory, where lists will do; see `check_run`.

    Raises
    ------
    InputFileError
        If one is missing.
    ParameterError
        If one is of another kind or shape, or holds infinity.
    """
    run = {k: v if isinstance(v, np.ndarray) else of_json(v) for k, v in given.items()}
    _check_keys(run)
    counts = {k: len(run[k]) for k in RUN_KEYS if k != "lip_vertex" and run[k].ndim}
    same = len(set(counts.values())) == 1  # otherwise `check_run` says how many frames there are
    layout = {k: v if same else replace(v, shape=(k, *v.shape[1:])) for k, v in _LAYOUT.items()}
    try:
        return run | check_arrays(Path("the run"), run, layout, "give arrays as load_run does")
    except ModelFormatError as error:
        raise ParameterError(error.problem, error.remedy) from error


def _check_keys(run: Mapping[str, object]) -> None:
    """Raise `InputFileError` if a run lacks an array."""
    missing = [key for key in RUN_KEYS if key not in run]
    if missing:
        raise InputFileError(f"the run lacks {', '.join(missing)}", "track the clip again")


def check_run(run: Mapping[str, NDArray[Any]], frames: int, vertices: int) -> None:
    """Raise unless a run has all arrays, and is of so many frames and of such a mesh.

    Raises
    ------
    InputFileError
        If it lacks an array.
    ParameterError
        If it is of other frames or of another mesh.
    """
    _check_keys(run)
    lengths = {len(run[key]) for key in RUN_KEYS if key != "lip_vertex"}
    if lengths != {frames}:
        raise ParameterError(
            f"the run has {' or '.join(map(str, sorted(lengths)))} frames, the truth {frames}",
            "evaluate a run of this very clip",
        )
    vertex = run["lip_vertex"]
    if len(vertex) == 0 or vertex.min() < 0 or vertex.max() >= vertices:
        raise ParameterError(
            f"the run's points are not among the truth's {vertices} vertices",
            "track with the speaker that was filmed",
        )


def of_run(
    name: str, run: Mapping[str, NDArray[Any]], surface: LinearSurface | None, areas: Areas
) -> Estimate:
    """The engine's own run as an estimate.

    Parameters
    ----------
    run : mapping of str to array
        As `load_run` gives it.
    surface : LinearSurface, optional
        The run's mesh.
    areas : mapping of str to vertex indices
        Lists on the mesh that are tracks of their own.
    """
    lips = np.asarray(run["lip_points"], np.float64)
    tracks = {"lip_points": PointTrack(run["lip_vertex"], lips)}
    if surface is not None:
        tracks |= {k: PointTrack(v, surface.points(v)) for k, v in areas.items()}
    aperture = np.asarray(run["aperture"], np.float64)
    estimate = Estimate(
        name=name,
        found=np.asarray(np.isfinite(lips).all(axis=(1, 2))),
        tracks=tracks,
        rotations=np.asarray(run["rotation"], np.float64),
        translations=np.asarray(run["translation"], np.float64),
        curves={"aperture": aperture, "width": np.asarray(run["width"], np.float64)},
        closed=np.asarray(run["closed"], bool) if "closed" in run else aperture < CLOSED_APERTURE,
        closed_by="own" if "closed" in run else "aperture",
        intervals=_intervals(run),
        surface=surface,
    )
    return within(estimate, np.asarray(run["found"], bool)) if "found" in run else estimate


def _intervals(run: Mapping[str, NDArray[Any]]) -> dict[str, tuple[FloatArray, FloatArray]]:
    """The 95 % intervals that a run gives, by standard deviations."""
    found = {}
    for name in ("lip_points", "aperture", "width"):
        if f"{name}_sd" in run:
            reach = NORMAL_95 * np.asarray(run[f"{name}_sd"], np.float64)
            found[name] = run[name] - reach, run[name] + reach
    return found
