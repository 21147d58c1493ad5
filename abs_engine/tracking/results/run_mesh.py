"""The tracked head as a mesh: what a run stores of it, and its reader."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import InputFileError, ModelFormatError
from abs_engine.core.kinds import checked_frame, to_path
from abs_engine.io.arrays import Layout, index, real
from abs_engine.io.assets import Speaker
from abs_engine.io.inputs import is_there
from abs_engine.io.npz import read_npz

MESH, FORMAT, VERSION = "mesh.npz", "abs_engine.run_mesh", 1
_LAYOUT: Layout = {
    "mean": real("V", 3, dtype=np.float32),
    "modes": real("P*", "V", 3, dtype=np.float32),
    "weights": real("T", "P*", gaps=True),
    "faces": index("V", "F", 3),
    "rest": real("V", 3, dtype=np.float32, optional=True),
}


@dataclass(frozen=True, eq=False)
class LinearSurface:
    """A mesh as a mean and modes: vertices(t) = mean + sum over p of weights[t, p] modes[p].

    Parameters
    ----------
    mean : (V, 3) float, mm, head frame
    modes : (P, V, 3) float, mm at weight 1
    weights : (T, P) float
        NaN in lost frames.
    """

    mean: NDArray[np.floating]
    modes: NDArray[np.floating]
    weights: NDArray[np.floating]

    def __len__(self) -> int:
        """Return the number of frames, T."""
        return len(self.weights)

    def vertices(self, frame: int) -> NDArray[np.float64]:
        """Vertices (V, 3), mm, head frame; NaN in a lost frame.

        Raises
        ------
        ParameterError
            If there is no such frame.
        """
        weights = self.weights[checked_frame(frame, len(self))]
        return np.asarray(self.mean + np.tensordot(weights, self.modes, 1), np.float64)

    def points(self, vertex: NDArray[np.integer]) -> NDArray[np.float64]:
        """Paths (T, N, 3), mm, head frame, of some vertices (N,)."""
        moved = np.tensordot(self.weights, self.modes[:, vertex].astype(np.float64), 1)
        return np.asarray(self.mean[vertex] + moved, np.float64)


@dataclass(frozen=True, eq=False, repr=False)
class RunMesh(LinearSurface):
    """The whole head of a run, as a linear shape with weights for each frame.

    Parameters
    ----------
    mean : (V, 3) float32, mm, head frame
        The person at weight 0: for most models the average of speech, with parted lips.
    faces : (F, 3) int32
    rest : (V, 3) float32, mm, head frame, or None
        The person without expression, with closed lips; None where the model does not say, and in
        runs of earlier versions. `face.neutral.neutral_face` starts from it.
    """

    mean: NDArray[np.float32]
    modes: NDArray[np.float32]
    weights: NDArray[np.float64]
    faces: NDArray[np.int32]
    rest: NDArray[np.float32] | None = None

    def __repr__(self) -> str:
        """Return a line that counts what it has."""
        return (
            f"<RunMesh of {len(self)} frames: {len(self.mean)} vertices, {len(self.faces)} faces, "
            f"{len(self.modes)} modes>"
        )

    def copied(self) -> RunMesh:
        """The same with arrays of its own: all runs with a head have its facets in common."""
        own: dict[str, Any] = {k: v.copy() for k, v in vars(self).items() if v is not None}
        return RunMesh(**own)

    def save(self, folder: Path) -> None:
        """Write ``mesh.npz`` into an existing folder."""
        arrays = {name: values for name, values in vars(self).items() if values is not None}
        np.savez_compressed(folder / MESH, format=FORMAT, version=VERSION, **arrays)


def load_mesh(folder: Path) -> RunMesh:
    """Read the mesh of a run, from its folder or the file itself.

    Raises
    ------
    InputFileError
        If the folder holds no ``mesh.npz``, or one that cannot be read.
    ModelFormatError
        If it has another format or version, or its arrays are not those of a mesh.
    """
    folder = to_path("folder", folder)
    folder = folder.parent if folder.name == MESH else folder
    path = folder / MESH
    if not is_there(folder):
        raise InputFileError(f"{folder} does not exist", "give a run's, as 'track' wrote it")
    if not is_there(path):
        raise InputFileError(f"{folder} holds no {MESH}", "track the video again")
    return RunMesh(**read_npz(path, FORMAT, VERSION, _LAYOUT, "track the video again"))


def load_mesh_of(folder: Path, speaker: Speaker) -> RunMesh:
    """Mesh of a run that was tracked with a head; raises as `load_mesh`, and for another head."""
    mesh = load_mesh(folder)
    if not np.array_equal(mesh.faces, speaker.faces):
        raise ModelFormatError(
            f"the run {folder} was tracked with another head", "give that head with --speaker"
        )
    return mesh
