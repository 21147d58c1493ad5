"""The record of a run: arrays of all frames, a table for spreadsheets, and the reader of both.

A run is a folder with ``results.npz`` (arrays, see `Recorder.arrays`), ``results.csv`` (a row for
each frame), ``closures.csv`` (a row for each time that the lips close), ``mesh.npz`` (the whole
head, see `RunMesh`), ``run.json`` (settings and a summary), ``overlay.mp4``, ``contact_sheet.png``
and ``head.png``; the colour classes, ``colours.npz``; and what it took, ``timing.json``.
"""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.camera import WIDEST_SIDE
from abs_engine.core.errors import InputFileError
from abs_engine.core.pose import parted
from abs_engine.core.provenance import made_by
from abs_engine.io.arrays import Layout, real, text, truth, whole
from abs_engine.io.npz import read_npz
from abs_engine.tracking.clip_setting import ClipSetting, FrameResult
from abs_engine.tracking.measures import NAMES, Closure, closures, measures
from abs_engine.tracking.run_mesh import RunMesh
from abs_engine.tracking.run_summary import summary
from abs_engine.tracking.run_table import (
    BELIEVED,
    LANDMARK_MEASURES,
    believed,
    cells,
    closed_frames,
    closure_table,
    contradicted_frames,
    rotation_vector,
    table_of,
    translation,
)

FloatArray = NDArray[np.float64]
FORMAT, VERSION = "abs_engine.run", 1
RESULTS, TABLE, SUMMARY = "results.npz", "results.csv", "run.json"
CLOSURES = "closures.csv"

_MEASURES = ("width", "aperture", "value", "score", "evaluations")
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
    **dict.fromkeys(("covered", "contradicted"), truth("T", optional=True)),
    **dict.fromkeys(_MEASURES, _OF_FRAME),
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


class Recorder:
    """Collects the results of a clip."""

    def __init__(self, setting: ClipSetting) -> None:
        self._setting = setting
        self._results: list[FrameResult] = []
        self._made = made_by()  # before the first frame: the code may change meanwhile

    def __len__(self) -> int:
        """Return the number of frames so far."""
        return len(self._results)

    def add(self, result: FrameResult) -> None:
        """Append the next frame, without the end of its search, which no run holds."""
        self._results.append(replace(result, highest=None))

    def arrays(self) -> dict[str, Any]:
        """Content of ``results.npz``, T frames.

        Rows of lost frames are NaN; so are those of covered frames, but for the head's pose.

        Returns
        -------
        dict
            `index` (T,), `time` (T,) s, `found`, `covered` (T,); `parameters` (T, 6 + P) named by
            `parameter_names`; `rotation` (T, 3) rotation vector and `translation` (T, 3) mm, head
            to camera; `lip_points` (T, N, 3) mm, head frame, which are the vertices `lip_vertex`
            (N,) of the head: outer, upper inner and lower inner contour; `width`, `aperture`
            and `protrusion` (T,) mm, `closed` (T,); the same with `_sd` and `rotation_sd`,
            `translation_sd` (T, 3), `lip_points_sd` (T, N, 3), standard deviations, and
            `closed_probability` (T,), see `fit.belief`; `contradicted` (T,), see
            `tracking.run_warnings`; `landmark_distance` and
            `landmark_aperture` (T,) mm, see `FrameResult`; `value`, `score`, `evaluations`,
            `status` (T,); `term_values` (T, K) by `term_names`, what `value` is the sum of, and
            `value_unit` (T,); what `tracking.measures` gives, (T,) each; `closure_frames` (C, 2),
            first and last, and `closure_times` (C, 2), onset and release, s; `person_weights`
            (Q,); `camera_matrix`, `camera_distortion`, `camera_size`, `rate`, `renderer`,
            `engine_version`, `format`, `version`.
        """
        results, setting = self._results, self._setting
        camera = setting.camera
        each = {
            k: np.array([getattr(r, k) for r in results])
            for k in ("index", "found", "covered", "protrusion", *_MEASURES, *LANDMARK_MEASURES)
        }
        return {
            "format": FORMAT,
            "version": VERSION,
            "engine_version": self._made["engine_version"],
            "renderer": setting.renderer.description,
            **each,
            "time": self._times(),
            "parameters": np.array([r.vector for r in results]),
            "parameter_names": setting.face.blocks.spec.names,
            "rotation": np.array([rotation_vector(r) for r in results]),
            "translation": np.array([translation(r) for r in results]),
            "lip_points": np.array([r.lips for r in results]),
            "lip_vertex": setting.face.body.lips,
            "closed": closed_frames(each["aperture"]),
            "contradicted": contradicted_frames(results),
            "status": np.array([r.status for r in results]),
            **self._terms(),
            **self._beliefs(),
            **self._measured(),
            **self._closures(),
            "person_weights": setting.face.identity,
            "camera_matrix": camera.matrix,
            "camera_distortion": camera.distortion,
            "camera_size": np.array(camera.size),
            "rate": setting.rate,
        }

    def _terms(self) -> dict[str, Any]:
        """Parts of each value, `term_values` (T, K) by `term_names` (K,)."""
        names = list(dict.fromkeys(name for r in self._results for name in r.terms))
        values = [[r.terms.get(name, np.nan) for name in names] for r in self._results]
        return {
            "term_names": np.array(names, np.str_),
            "term_values": np.array(values, np.float64).reshape(len(values), len(names)),
            "value_unit": np.array([r.unit for r in self._results]),
        }

    def _beliefs(self) -> dict[str, Any]:
        """Standard deviations, and the probability that lips are closed; NaN where not known."""
        count = len(self._setting.face.body.lips)
        sizes = {
            **{f"{name}_sd": () for name in BELIEVED},
            "lip_points_sd": (count, 3), "rotation_sd": (3,), "translation_sd": (3,),
            "closed_probability": (),
        }  # fmt: skip
        return {
            name: np.array([believed(r, name, size) for r in self._results]).reshape(-1, *size)
            for name, size in sizes.items()
        }

    def mesh(self) -> RunMesh:
        """The whole head in every frame."""
        body = self._setting.face.body
        weights = np.array([parted(r.vector)[1] for r in self._results])
        return RunMesh(body.mean, body.modes, weights.reshape(-1, len(body.modes)), body.faces)

    def table(self) -> list[list[Any]]:
        """The table of all frames, its heading first."""
        return table_of(self._setting, self._results, self._times(), self._measured())

    def _times(self) -> NDArray[np.float64]:
        """Time at which each frame is shown, (T,), seconds: as the video says, or by its rate."""
        count, setting = len(self._results), self._setting
        if len(setting.times) == count:
            return np.array(setting.times, np.float64)
        return np.arange(count) / setting.rate

    def _measured(self) -> dict[str, FloatArray]:
        """Measures of lips, jaw and head by their names, (T,) each."""
        results, face = self._results, self._setting.face
        lost = np.full(len(face.blocks.spec), np.nan)
        postures = [parted(r.vector if r.found else lost)[1] for r in results]
        flat = np.array(postures, np.float64).reshape(len(results), -1)
        return measures(face, self._times(), flat, [r.pose for r in results])

    def closures(self) -> list[Closure]:
        """Each time that the lips close."""
        aperture = np.array([r.aperture for r in self._results], np.float64)
        return closures(aperture, self._times())

    def _closures(self) -> dict[str, NDArray[Any]]:
        """Closures as arrays of C rows."""
        found = self.closures()
        frames = np.array([(c.first, c.last) for c in found], np.int64)
        times = np.array([(c.onset, c.release) for c in found], np.float64)
        return {"closure_frames": frames.reshape(-1, 2), "closure_times": times.reshape(-1, 2)}

    def summary(self) -> dict[str, Any]:
        """Counts of frames, means of those tracked, and warnings; see `run_summary.summary`."""
        return summary(self._results, self._setting.face)

    def write(self, folder: Path, facts: dict[str, Any]) -> dict[str, Any]:
        """Write tables, arrays and mesh into an existing folder.

        Parameters
        ----------
        folder : Path
        facts : dict
            What else ``run.json`` says, JSON values.

        Returns
        -------
        dict
            What ``run.json`` holds.
        """
        arrays = self.arrays()
        np.savez_compressed(folder / RESULTS, **arrays)
        self.mesh().save(folder)
        with (folder / TABLE).open("w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows(map(cells, self.table()))
        with (folder / CLOSURES).open("w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows(map(cells, closure_table(self.closures())))
        heading = {k: arrays[k] for k in ("format", "version", "renderer")} | self._made
        told = {**heading, **facts, "summary": {**self.summary(), **facts.get("summary", {})}}
        (folder / SUMMARY).write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
        return told


def load_run(folder: Path) -> dict[str, NDArray[Any]]:
    """Read the arrays of a run; see `Recorder.arrays`.

    Raises
    ------
    InputFileError
        If the folder holds no ``results.npz``, or one that cannot be read.
    ModelFormatError
        If it has another format or version, or its arrays do not fit together.
    """
    folder = Path(folder)
    path = folder / RESULTS
    if not path.is_file():
        raise InputFileError(
            f"{folder} is not a run: {RESULTS} is missing", "give the folder that 'track -o' made"
        )
    return read_npz(path, FORMAT, VERSION, _LAYOUT, "track the video again")
