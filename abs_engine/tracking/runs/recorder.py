"""The recorder of a clip: it takes results frame by frame, and makes the record of a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.pose import parted
from abs_engine.core.provenance import made_by
from abs_engine.fit.head_frame import COLOUR
from abs_engine.tracking.frame.clip_setting import GREY, ClipSetting, FrameResult
from abs_engine.tracking.results.frame_rows import BELIEFS, OWN, FrameRows
from abs_engine.tracking.results.less_explained import doubted, less_explained, shortfall
from abs_engine.tracking.results.measures import (
    NAMES,
    Closure,
    closure_arrays,
    closures,
    velocities,
)
from abs_engine.tracking.results.mouth_check import MouthCheck
from abs_engine.tracking.results.other_faces import OtherFaces
from abs_engine.tracking.results.run_mesh import RunMesh
from abs_engine.tracking.results.run_table import LESS, closed_frames
from abs_engine.tracking.results.still_face import StillFace
from abs_engine.tracking.runs.record import FORMAT, VERSION, Record
from abs_engine.tracking.runs.run_summary import score_of, summary


class Recorder:
    """Collects the results of a clip.

    Parameters
    ----------
    folder : Path, optional
        Where their numbers are kept until they are written; see `FrameRows`.
    """

    def __init__(self, setting: ClipSetting, folder: Path | None = None) -> None:
        self._setting, self._rows = setting, FrameRows(setting.face, folder)
        self._looks = MouthCheck(setting), OtherFaces(setting), StillFace(setting)
        self._made = made_by()  # before the first frame: the code may change meanwhile

    def __len__(self) -> int:
        """Return the number of frames so far."""
        return len(self._rows)

    def add(self, result: FrameResult, image: Image | None = None) -> None:
        """Append the next frame, without the end of its search, which no run holds.

        With its picture (H, W, 3) RGB, some frames are looked at again, see `MouthCheck`,
        `OtherFaces` and `StillFace`.

        Raises
        ------
        OSError
            If it cannot be kept.
        """
        self._rows.add(result)
        if image is not None:
            for look in self._looks:
                look.add(image, result)

    def record(self) -> Record:
        """All frames so far; what is of a frame by itself lies where its rows do."""
        rows, time, body = self._doubted(), self._times(), self._setting.face.body
        found = closures(rows["aperture"], time, rows["cut"])
        arrays = self._arrays(rows, time, found)
        weights = parted(rows["parameters"])[1].copy()
        mesh = RunMesh(body.mean, body.modes, weights, body.faces, body.rest)
        seen = [line for look in self._looks for line in look.warnings()]
        counts = summary(arrays, self._setting, seen)
        return Record(arrays, rows["points"], mesh, found, counts, self._made)

    def _doubted(self) -> dict[str, NDArray[Any]]:
        """Numbers of all frames; where one is explained less than the others, it is doubted."""
        rows = self._rows.columns()
        score = np.where(rows["status"] == GREY, np.nan, rows["score"])
        source = score_of(rows["term_names"].tolist(), self._setting.face.name)
        short = shortfall(score if source == COLOUR else np.full_like(score, np.nan))
        return {**rows, **doubted(rows, short), LESS: less_explained(short)}

    def _arrays(
        self, rows: Mapping[str, NDArray[Any]], time: FloatArray, found: Sequence[Closure]
    ) -> dict[str, Any]:
        """Content of ``results.npz``."""
        setting = self._setting
        measured = {**rows, **velocities(rows, time, rows["cut"])}
        return {
            "format": FORMAT,
            "version": VERSION,
            "engine_version": self._made["engine_version"],
            "renderer": setting.renderer.description,
            **{name: rows[name] for name in OWN},
            "time": time,
            "parameters": rows["parameters"],
            "parameter_names": setting.face.blocks.spec.names,
            **{name: rows[name] for name in ("rotation", "translation", "lip_points")},
            "lip_vertex": setting.face.body.lips,
            "closed": closed_frames(rows["aperture"]),
            **{name: rows[name] for name in ("status", "term_names", "term_values", "value_unit")},
            **{name: rows[name] for name in (*BELIEFS, LESS)},
            **{name: measured[name] for name in NAMES},
            **closure_arrays(found),
            "person_weights": setting.face.identity,
            "camera_matrix": setting.camera.matrix,
            "camera_distortion": setting.camera.distortion,
            "camera_size": np.array(setting.camera.size),
            "rate": setting.rate,
        }

    def _times(self) -> NDArray[np.float64]:
        """Time at which each frame is shown, (T,), seconds: as the video says, or by its rate."""
        count, setting = len(self), self._setting
        if len(setting.times) == count:
            return np.array(setting.times, np.float64)
        return np.arange(count) / setting.rate
