"""The numbers of a clip's frames, kept in a file: memory does not grow with the clip."""

from __future__ import annotations

import tempfile
import weakref
from array import array
from collections.abc import Mapping
from pathlib import Path
from sys import intern
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import OutputError
from abs_engine.core.pose import parted
from abs_engine.face.base import Face
from abs_engine.io.assets import LIPS_OF_68
from abs_engine.tracking.frame.clip_setting import FrameResult
from abs_engine.tracking.results.measures import OF_FRAME, of_frame

BELIEVED = ("width", "aperture", "protrusion")
LANDMARK_MEASURES = ("landmark_distance", "landmark_aperture")
MARKS = ("covered", "cut", "contradicted")
MEASURES = ("width", "aperture", "value", "score", "evaluations")
OWN = ("index", "found", *MARKS, "protrusion", *MEASURES, *LANDMARK_MEASURES)
"""Numbers that a row takes from `FrameResult`, under their names there."""
BELIEFS = (
    *(f"{name}_sd" for name in (*BELIEVED, "lip_points", "rotation", "translation")),
    "closed_probability",
)
"""Numbers that `believed` takes from a frame's belief."""
POINTS = len(range(68)[LIPS_OF_68])
_TYPES = {
    **dict.fromkeys(("index", "evaluations"), np.int64),
    **dict.fromkeys(("found", *MARKS), np.bool_),
}


class FrameRows:
    """Takes results frame by frame, and gives their numbers as columns.

    In memory stay 8 bytes a frame for its status, and for each term.

    Parameters
    ----------
    folder : Path, optional
        Where the file lies, without a name there; by default, where temporary files do.
    """

    def __init__(self, face: Face, folder: Path | None = None) -> None:
        self._face, self._row = face, np.zeros(1, _row(face))
        self._status: list[str] = []
        self._terms: dict[str, array[float]] = {}
        self._where = folder
        try:
            # closed as this is
            self._file = tempfile.TemporaryFile(dir=folder, buffering=0)  # noqa: SIM115
        except OSError as error:
            self._fail(error)
        weakref.finalize(self, self._file.close)

    def __len__(self) -> int:
        """Return the number of frames so far, T."""
        return len(self._status)

    def add(self, result: FrameResult) -> None:
        """Append the next frame.

        Raises
        ------
        OSError
            If it cannot be written to the folder that was given.
        OutputError
            If temporary files cannot be written.
        """
        row = self._row[0]
        for name, number in _numbers(self._face, result).items():
            row[name] = number
        left = memoryview(self._row.tobytes())
        try:
            while left:
                left = left[self._file.write(left) :]
        except OSError as error:
            self._fail(error)
        for name in result.terms:
            self._terms.setdefault(name, array("d", [np.nan]) * len(self))
        for name, values in self._terms.items():
            values.append(result.terms.get(name, np.nan))
        self._status.append(intern(result.status))

    def _fail(self, error: OSError) -> NoReturn:
        if self._where is not None:
            raise error
        raise OutputError(
            f"temporary files cannot be written ({error.strerror or error})",
            "let TMPDIR name a folder with space left, or give an output",
        ) from error

    def columns(self) -> dict[str, NDArray[Any]]:
        """Numbers of all frames by their names, (T, ...) each; they cannot be written to.

        Returns
        -------
        dict
            What `Record` describes, but for what follows from several frames; `points`
            (T, 20, 3), mm, head frame: the usual lip points. Most stay in the file until they are
            used.
        """
        kind, count = self._row.dtype, len(self)
        # An empty file cannot be mapped
        rows = np.memmap(self._file, kind, "r", shape=count) if count else np.zeros(0, kind)
        values = [np.array(one) for one in self._terms.values()]
        return {
            **{name: np.asarray(rows[name]) for name in kind.names or ()},
            "status": np.array(self._status, np.str_),
            "term_names": np.array(list(self._terms), np.str_),
            "term_values": np.array(values).reshape(len(values), count).T.copy(),
        }


def _row(face: Face) -> np.dtype[np.void]:
    """Kind of a frame's row."""
    lips = len(face.body.lips), 3
    shapes: dict[str, tuple[int, ...]] = {
        **dict.fromkeys((*OWN, "value_unit", *BELIEFS, *OF_FRAME), ()),
        "parameters": (len(face.blocks),),
        **dict.fromkeys(("rotation", "translation", "rotation_sd", "translation_sd"), (3,)),
        **dict.fromkeys(("lip_points", "lip_points_sd"), lips),
        "points": (POINTS, 3),
    }
    fields = [(name, _TYPES.get(name, np.float64), shape) for name, shape in shapes.items()]
    return np.dtype(fields, align=True)


def _numbers(face: Face, result: FrameResult) -> Mapping[str, Any]:
    """A frame's row; NaN is what is not known."""
    vertices = face.scene.vertices(parted(result.vector)[1]) if result.found else None
    return {
        **{name: getattr(result, name) for name in OWN},
        "value_unit": result.unit,
        "parameters": result.vector,
        "rotation": np.nan if result.pose is None else result.pose.rotation_vector,
        "translation": np.nan if result.pose is None else result.pose.translation,
        "lip_points": result.lips,
        "points": np.nan if vertices is None else vertices[face.rings["points"]],
        **{name: believed(result, name) for name in BELIEFS},
        **of_frame(face, vertices, result.pose),
    }


def believed(result: FrameResult, name: str) -> Any:
    """A number of a frame's belief, or an array, by its name in results; NaN where unknown."""
    own = {"lip_points_sd": "lips", "closed_probability": "closed"}.get(name)
    return getattr(result.belief, own or name.removesuffix("_sd"), np.nan)
