"""The record of a run: arrays of all frames, a table for spreadsheets, and the reader of both.

A run is a folder with ``results.npz`` (arrays, see `Record`), ``results.csv`` (a row for
each frame), ``closures.csv`` (a row for each time that the lips close), ``mesh.npz`` (the whole
head, see `RunMesh`), ``run.json`` (settings and a summary), ``overlay.mp4``, ``contact_sheet.png``
and ``head.png``; the colour classes, ``colours.npz``; and what it took, ``timing.json``.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import WIDEST_SIDE, Camera
from abs_engine.core.errors import InputFileError, ModelFormatError
from abs_engine.core.kinds import to_path
from abs_engine.io.arrays import Layout, real, text, truth, whole
from abs_engine.io.assets import Speaker
from abs_engine.io.csv_table import read_table
from abs_engine.io.inputs import is_there, read_json
from abs_engine.io.npz import read_npz
from abs_engine.tracking.results.frame_rows import BELIEVED, LANDMARK_MEASURES, MEASURES
from abs_engine.tracking.results.measures import NAMES, Closure, closures, cuts
from abs_engine.tracking.results.run_mesh import RunMesh, load_mesh, load_mesh_of
from abs_engine.tracking.results.run_table import (
    LESS,
    POINT_NAMES,
    closure_table,
    table_of,
    written,
)

FORMAT, VERSION = "abs_engine.run", 1
RESULTS, TABLE, SUMMARY = "results.npz", "results.csv", "run.json"
CLOSURES = "closures.csv"

_OF_FRAME = real("T", gaps=True)
_MORE = replace(_OF_FRAME, optional=True)
_PLACE_SD = real("T", 3, gaps=True, optional=True)
_LAYOUT: Layout = {
    "format": text(),
    "version": whole(),
    "index": whole("T", low=0),
    "time": real("T"),
    "found": truth("T"),
    "parameters": real("T", "P*", gaps=True),
    "parameter_names": text("P*", optional=True),
    **dict.fromkeys(("rotation", "translation"), real("T", 3, gaps=True)),
    "lip_points": real("T", "N", 3, gaps=True),
    "lip_vertex": whole("N", dtype=np.int32, low=0),
    "closed": truth("T"),
    **dict.fromkeys(("covered", "contradicted", LESS, "cut"), truth("T", optional=True)),
    **dict.fromkeys(MEASURES, _OF_FRAME),
    "evaluations": whole("T", low=0),
    "status": text("T"),
    "protrusion": _MORE,
    **dict.fromkeys((*LANDMARK_MEASURES, *NAMES, "closed_probability"), _MORE),
    **dict.fromkeys([f"{name}_sd" for name in BELIEVED], _MORE),
    **dict.fromkeys(("rotation_sd", "translation_sd"), _PLACE_SD),
    "lip_points_sd": real("T", "N", 3, gaps=True, optional=True),
    "term_names": text("K*", optional=True),
    "term_values": real("T", "K*", gaps=True, optional=True),
    "value_unit": _MORE,
    "closure_frames": whole("C*", 2, low=0, optional=True),
    "closure_times": real("C*", 2, gaps=True, optional=True),
    "person_weights": real("Q*", optional=True),
    "camera_matrix": real(3, 3, optional=True),
    "camera_distortion": real(8, optional=True),
    "camera_size": whole(2, low=1, high=WIDEST_SIDE, optional=True),
    "rate": real(low=1e-9, optional=True),
    **dict.fromkeys(("renderer", "engine_version"), text(optional=True)),
}


@dataclass(frozen=True, eq=False)
class Record:
    """Results of a clip of T frames, as the files of a run hold them.

    Rows of lost frames are NaN; so are those of covered frames, but for the head's pose.

    Parameters
    ----------
    arrays : dict of str to array
        `index` (T,), `time` (T,) s, `found`, `covered` (T,); `parameters` (T, 6 + P) named by
        `parameter_names`; `rotation` (T, 3) rotation vector and `translation` (T, 3) mm, head
        to camera; `lip_points` (T, N, 3) mm, head frame, which are the vertices `lip_vertex`
        (N,) of the head: outer, upper inner and lower inner contour; `width`, `aperture`
        and `protrusion` (T,) mm, `closed` (T,); the same with `_sd` and `rotation_sd`,
        `translation_sd` (T, 3), `lip_points_sd` (T, N, 3), standard deviations, and
        `closed_probability` (T,), see `fit.belief`; `contradicted` (T,), see
        `FrameResult`; `less_explained` (T,), see the module of that name; `cut` (T,);
        `landmark_distance` and `landmark_aperture` (T,) mm, see `FrameResult`; `value`, `score`,
        `evaluations`, `status` (T,); `term_values` (T, K) by `term_names`, what `value` is the sum
        of, and `value_unit` (T,); what `tracking.results.measures` gives, (T,) each;
        `closure_frames` (C, 2), first and last, and `closure_times` (C, 2), onset and release, s;
        `person_weights` (Q,); `camera_matrix`, `camera_distortion`, `camera_size`, `rate`,
        `renderer`, `engine_version`, `format`, `version`.
    points : (T, 20, 3) float64, mm, head frame
        The usual lip points.
    summary : dict
        Counts of frames, means of those tracked, and warnings; see `run_summary.summary`.
    made : dict
        What made them, see `made_by`.
    """

    arrays: dict[str, Any]
    points: FloatArray
    mesh: RunMesh
    closures: Sequence[Closure]
    summary: dict[str, Any]
    made: dict[str, Any]

    def copied(self) -> Record:
        """The same in memory, and free to be written to."""
        arrays = {k: v.copy() if isinstance(v, np.ndarray) else v for k, v in self.arrays.items()}
        return replace(self, arrays=arrays, points=self.points.copy(), mesh=self.mesh.copied())

    def table(self) -> Iterator[list[Any]]:
        """The table of all frames, its heading first."""
        return table_of(self.arrays, self.points)

    def write(self, folder: Path, facts: dict[str, Any]) -> dict[str, Any]:
        """Write tables, arrays and mesh into an existing folder.

        What ``run.json`` holds is returned; the facts, JSON values, are what else it says.
        """
        np.savez_compressed(folder / RESULTS, **self.arrays)
        self.mesh.save(folder)
        for name, table in ((TABLE, self.table()), (CLOSURES, closure_table(self.closures))):
            with (folder / name).open("w", encoding="utf-8", newline="") as file:
                csv.writer(file).writerows(written(table))
        heading = {k: self.arrays[k] for k in ("format", "version", "renderer")} | self.made
        told = {**heading, **facts, "summary": {**self.summary, **facts.get("summary", {})}}
        (folder / SUMMARY).write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
        return told


_CAMERA = ("camera_matrix", "camera_size", "camera_distortion")
_OF_TRACK = "give the folder that 'track -o' made"
_AGAIN = "track the video again"


def load_run(folder: Path) -> dict[str, NDArray[Any]]:
    """Read the arrays of a run, from its folder or the file itself; see `Record`.

    Raises
    ------
    InputFileError
        If there is no such folder, or its ``results.npz`` is missing or cannot be read.
    ModelFormatError
        If it has another format or version, or its arrays do not fit together.
    """
    folder = to_path("folder", folder)
    folder = folder.parent if folder.name == RESULTS else folder
    if not is_there(folder):
        raise InputFileError(f"{folder} does not exist", _OF_TRACK)
    if not is_there(folder / RESULTS):
        runs = sorted(one.parent for one in folder.glob(f"*/{RESULTS}"))
        one = f"give one of the runs in it, such as {runs[0]}" if runs else _OF_TRACK
        raise InputFileError(f"{folder} is not a run: {RESULTS} is missing", one)
    return read_npz(folder / RESULTS, FORMAT, VERSION, _LAYOUT, _AGAIN)


def load_record(folder: Path) -> Record:
    """Read the record of a run, from its folder; its points have the digits of ``results.csv``.

    Raises
    ------
    InputFileError
        If the folder is no run, or one of its files is missing or cannot be read.
    ModelFormatError
        If one has another format or version, or they do not fit together.
    """
    arrays = {k: v if v.ndim else v.item() for k, v in load_run(folder).items()}
    mesh = load_mesh(folder)
    try:
        told = stated(folder)
        summary = dict(told["summary"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputFileError(f"{folder / SUMMARY} states no summary", _AGAIN) from error
    frames = len(arrays["found"])
    at = [f"{name}_{axis}" for name in POINT_NAMES for axis in "xyz"]
    table = read_table(folder / TABLE, remedy=_AGAIN)
    table.require(at, _AGAIN)
    points = table.numbers(at, gaps=True)
    if not frames == len(mesh) == len(points):
        raise ModelFormatError(f"files of {folder} are of different runs", _AGAIN)
    found = closures(arrays["aperture"], arrays["time"], cuts(arrays))
    made = {name: told.get(name) for name in ("engine_version", "commit", "dirty")}
    return Record(arrays, points.reshape(frames, -1, 3), mesh, found, summary, made)


def stated(folder: Path) -> dict[str, Any]:
    """Content of a run's ``run.json``.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        If it is no JSON object.
    """
    told = read_json(folder / SUMMARY, gaps=True)
    if not isinstance(told, dict):
        raise ValueError("no JSON object")
    return told


def stated_settings(folder: Path) -> dict[str, Any]:
    """Settings that a run's ``run.json`` states; a summary beside them may hold unknown numbers.

    Raises
    ------
    OSError, ValueError
        As `stated`.
    KeyError
        If it states none.
    """
    settings = stated(folder).get("settings")
    if not isinstance(settings, dict):
        raise KeyError("settings")
    return settings


def run_settings(folder: Path) -> dict[str, Any]:
    """The same; none where there is no such file that can be read."""
    try:
        return stated_settings(Path(folder))
    except (OSError, ValueError, KeyError):
        return {}


def load_whole_run(
    folder: Path, speaker: Speaker, needs: Sequence[str] = ()
) -> tuple[dict[str, NDArray[Any]], RunMesh]:
    """Arrays and mesh of a run that was tracked with a head.

    Raises
    ------
    InputFileError
        If the folder is no run.
    ModelFormatError
        If its files do not fit together, are of another head, or lack the camera or what `needs`
        names.
    """
    arrays, mesh = load_run(folder), load_mesh_of(folder, speaker)
    if len(mesh) != len(arrays["found"]):
        raise ModelFormatError(
            f"{folder} has {len(arrays['found'])} frames and {len(mesh)} meshes", _AGAIN
        )
    missing = [name for name in (*_CAMERA, "rate", *needs) if name not in arrays]
    if missing:
        raise ModelFormatError(f"the run {folder} lacks {', '.join(missing)}", "track it again")
    return arrays, mesh


def camera_of(run: Mapping[str, NDArray[Any]]) -> Camera:
    """Camera of the video of a run that has one."""
    matrix, size, distortion = (run[name] for name in _CAMERA)
    return Camera(matrix, (int(size[0]), int(size[1])), distortion)
