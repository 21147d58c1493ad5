"""The base of exporters: what an exporter is given, and what it reports."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.errors import InputFileError
from abs_engine.core.geometry import FACING, Pose
from abs_engine.face.neutral import neutral_face
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.io.inputs import is_there
from abs_engine.tracking.results.measures import closure_arrays, closures, cuts
from abs_engine.tracking.results.run_mesh import RunMesh
from abs_engine.tracking.runs.record import SUMMARY, camera_of, load_whole_run, stated_settings

_ROUNDING = {"s": 1e-6, "mm": 1e-2, "px": 1e-2, "degrees": 1e-2, "": 1e-4}
"""Differences by their units, up to which they are of rounding."""


@dataclass(frozen=True)
class Loss:
    """Difference between a file that is read back and its run.

    It is of rounding, or of what a format cannot hold: then `by` says by what it approximates it.

    Parameters
    ----------
    value : float
        RMS difference; NaN where there is nothing to compare, as without any closure.
    unit : str
    of : str
        What was compared.
    note : str
        Remark for the user, in one line; usually empty.
    by : str
        Numbers that stand in for what was compared, such as ARKit's 52 weights; usually empty.
    """

    value: float
    unit: str
    of: str
    note: str = ""
    by: str = ""

    def __str__(self) -> str:
        if np.isnan(self.value):
            return f"{self.of}: nothing to compare"
        size = " ".join(filter(None, (f"{self.value:.3g}", self.unit, "RMS")))
        return f"{self.by} reproduce {self.of} to {size}" if self.by else f"{self.of}: {size}"

    @property
    def rounded(self) -> bool:
        """Whether it is of rounding alone."""
        return not self.by and self.value <= _ROUNDING.get(self.unit, 0.0)


@dataclass(frozen=True)
class Exporter:
    """A format that runs are written in.

    Parameters
    ----------
    text : str
        What it is, a line for the list of formats.
    write : callable
        Given the run and where to write, a file or an empty folder; returns what is lost.
    suffix : str
        How the file's name ends; empty for a format that is a folder.
    needs : tuple of str
        Arrays that it cannot be written without, and that older runs may lack.
    """

    text: str
    write: Callable[[TrackedRun, Path], tuple[Loss, ...]]
    suffix: str = ""
    needs: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class TrackedRun:
    """A run as exporters see it.

    Parameters
    ----------
    folder : Path
    arrays : dict of str to array
        See `abs_engine.load_run`.
    mesh : RunMesh
        The head in every frame.
    speaker : Speaker
        The head's face units, classes and landmarks.
    sound : float
        When the video's sound begins, s after the first picture; 0 where the run does not say.
    """

    folder: Path
    arrays: dict[str, NDArray[Any]]
    mesh: RunMesh
    speaker: Speaker
    sound: float = 0.0

    def __len__(self) -> int:
        """Return the number of frames, T."""
        return len(self.arrays["found"])

    @property
    def rate(self) -> float:
        """Frames per second."""
        return float(self.arrays["rate"])

    @cached_property
    def shown(self) -> BoolArray:
        """Whether a frame has a posture and a pose, (T,)."""
        known = np.isfinite(self.mesh.weights).all(axis=1)
        return np.asarray(known & np.isfinite(self.arrays["rotation"]).all(axis=1))

    @cached_property
    def frames(self) -> list[int]:
        """Numbers of the frames that have a posture and a pose."""
        return [int(frame) for frame in np.flatnonzero(self.shown)]

    def in_all(self, values: FloatArray) -> FloatArray:
        """Values (F, ...) of these `frames` in all frames, (T, ...); NaN in lost ones."""
        out = np.full((len(self), *values.shape[1:]), np.nan)
        out[self.frames] = values
        return out

    @cached_property
    def turns(self) -> Rotation:
        """Rotations of the head away from looking along the camera's axis, in these `frames`."""
        vectors = self.arrays["rotation"][self.frames]
        return Rotation.from_matrix(FACING.T) * Rotation.from_rotvec(vectors)

    @cached_property
    def camera(self) -> Camera:
        """The camera of the video."""
        return camera_of(self.arrays)

    @cached_property
    def neutral(self) -> FloatArray:
        """The person's neutral face, whose lips just meet: (V, 3) mm, head frame."""
        return neutral_face(self.mesh, self.speaker.points["landmark_68"])

    def pose(self, frame: int) -> Pose:
        """Head to camera."""
        return Pose.from_vectors(self.arrays["rotation"][frame], self.arrays["translation"][frame])

    @cached_property
    def landmarks(self) -> FloatArray:
        """The 68 landmarks in the head's frame, (T, 68, 3) mm; NaN in lost frames."""
        return self.points(self.speaker.points["landmark_68"])

    def points(self, vertex: NDArray[np.integer]) -> FloatArray:
        """Paths (T, N, 3) mm, head frame, of some vertices (N,); NaN in lost frames."""
        out = self.mesh.points(vertex)
        out[~self.shown] = np.nan
        return out

    @cached_property
    def landmarks_in_camera(self) -> FloatArray:
        """The 68 landmarks in the camera's frame, (T, 68, 3) mm; NaN in lost frames."""
        placed = [self.pose(frame).apply(self.landmarks[frame]) for frame in self.frames]
        return self.in_all(np.array(placed))

    @cached_property
    def landmarks_in_picture(self) -> FloatArray:
        """The 68 landmarks in the picture, (T, 68, 2) px; NaN in lost frames."""
        seen = [self.camera.project(self.landmarks_in_camera[frame]) for frame in self.frames]
        return self.in_all(np.array(seen))


def read_run(folder: Path, speaker: Path | None = None, needs: tuple[str, ...] = ()) -> TrackedRun:
    """Read a run with its mesh and its head.

    Parameters
    ----------
    speaker : Path, optional
        The head that it was tracked with, if not the bundled one.
    needs : tuple of str
        Arrays that it must hold, besides those that every format needs.

    Raises
    ------
    InputFileError
        If the folder is no run, or its ``run.json`` is damaged.
    ModelFormatError
        If its files do not fit together, or are of another head.
    """
    head = load_speaker(speaker)
    arrays, mesh = load_whole_run(folder, head, needs)
    # Older runs have none
    found = closure_arrays(closures(arrays["aperture"], arrays["time"], cuts(arrays)))
    return TrackedRun(Path(folder), found | arrays, mesh, head, _sound(Path(folder)))


def _sound(folder: Path) -> float:
    """Beginning of the sound, s after the first picture; 0 where nothing says it.

    Raises
    ------
    InputFileError
        If the file is there but cannot be read.
    """
    if not is_there(folder / SUMMARY):
        return 0.0
    try:
        sound = stated_settings(folder).get("sound")
    except KeyError:
        return 0.0
    except (OSError, ValueError) as error:
        raise InputFileError(
            f"{folder / SUMMARY} is damaged", "restore it, or track the video again"
        ) from error
    return float(sound) if isinstance(sound, int | float) and np.isfinite(sound) else 0.0


def rms(differences: FloatArray) -> float:
    """Root mean square of all that is finite; of vectors (..., 3), of their lengths."""
    known = differences[np.isfinite(differences)]
    rows = known.size // differences.shape[-1] if differences.ndim > 1 else known.size
    return float(np.sqrt((known**2).sum() / rows)) if rows else float("nan")
