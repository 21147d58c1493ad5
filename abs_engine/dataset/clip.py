"""A clip's truth for all cameras: the person, the motion, the speech."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray, IntArray
from abs_engine.core.geometry import Pose
from abs_engine.core.kinds import checked_frame
from abs_engine.dataset.codec import FORMAT, TRUTH, VERSION
from abs_engine.dataset.offsets import StoredOffsets
from abs_engine.dataset.picture import AGAIN
from abs_engine.io.arrays import Layout, index, plain, real, text, truth, whole
from abs_engine.io.npz import read_npz

LANDMARKS = ("outer_lip", "outer_lip_20", "inner_lip_8", "mouth_corners", "landmark_68")


class Phoneme(NamedTuple):
    """Sound spoken from `start` to `end`, seconds."""

    label: str
    start: float
    end: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Clip:
    """A person who says something. Lengths in mm, angles in radians.

    Parameters
    ----------
    name : str
        Of the clip in its dataset.
    rate : float
        Frames per second.
    person, sentence, command : str
        Who is filmed, what is said, and the command that filmed it.
    unit_weights : (T, 52) float64
    identity_weights : (K,) float32
    neutral : (V, 3) float32, head frame
        The person at rest.
    offsets : (T, V, 3) float16, head frame
        Read when they are wanted, or an array. What was filmed is exactly neutral + offsets.
    faces : (F, 3) int32
    facet_class : (F,) uint8, index into `class_names`
    uv : (V, 2) float32
        Texture coordinates, v down from the top; empty where there are none.
    world_rotations : (T, 3) float64
        Rotation vectors, head to world.
    world_translations : (T, 3) float64, world frame
    phonemes : tuple of str
        One for each frame.
    closed : (T,) bool
        The lips touch all along, measured on the mesh.
    gap : (T,) float64
        Widest gap between the lips, mm; negative where they overlap everywhere.
    landmarks : mapping of str to int32 vertex indices
        outer_lip, outer_lip_20, inner_lip_8, mouth_corners, landmark_68.
    """

    name: str = ""
    rate: float
    person: str
    sentence: str
    command: str
    seed: int
    unit_names: tuple[str, ...]
    unit_weights: FloatArray
    identity_weights: NDArray[np.float32]
    neutral: NDArray[np.float32]
    offsets: StoredOffsets | NDArray[np.float16]
    faces: NDArray[np.int32]
    facet_class: NDArray[np.uint8]
    class_names: tuple[str, ...]
    uv: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 2), np.float32))
    world_rotations: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    world_translations: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    phonemes: tuple[str, ...] = ()
    intervals: tuple[Phoneme, ...] = ()
    closed: BoolArray
    gap: FloatArray = field(default_factory=lambda: np.zeros(0))
    landmarks: Mapping[str, NDArray[np.int32]]

    def __len__(self) -> int:
        """Return the number of frames, T."""
        return len(self.offsets)

    def vertices(self, frame: int) -> NDArray[np.float32]:
        """Vertices (V, 3), mm, head frame, in a frame; `ParameterError` where there is none."""
        offset = self.offsets[checked_frame(frame, len(self))]
        return np.asarray(self.neutral + offset.astype(np.float32), np.float32)

    def points(self, vertex: NDArray[np.integer]) -> FloatArray:
        """The paths (T, N, 3), mm, head frame, of some vertices (N,); read frame after frame."""
        out = np.empty((len(self), len(vertex), 3))
        for frame in range(len(self)):
            out[frame] = self.offsets[frame][vertex]
        return np.asarray(out + self.neutral[vertex])

    def world_pose(self, frame: int) -> Pose:
        """Head to world in a frame; `ParameterError` where there is none."""
        frame = checked_frame(frame, len(self))
        return Pose.from_vectors(self.world_rotations[frame], self.world_translations[frame])

    @cached_property
    def weld(self) -> IntArray:
        """Number (V,) of the place where each vertex rests; copies at texture seams share it."""
        _, number = np.unique(self.neutral, axis=0, return_inverse=True)
        return np.asarray(number.ravel())

    @cached_property
    def aperture(self) -> FloatArray:
        """Height (T,), mm, between the inner lips in the middle; 0 where they overlap.

        y of point 62 less y of point 66 of the 68 (`inner_lip_8` 2 and 6), head frame.
        """
        inner = self.points(np.asarray(self.landmarks["inner_lip_8"])[[2, 6]])
        return np.asarray(np.maximum(inner[:, 0, 1] - inner[:, 1, 1], 0.0))

    @cached_property
    def width(self) -> FloatArray:
        """Distance (T,), mm, between the outer corners of the mouth."""
        corners = self.points(self.landmarks["mouth_corners"])
        return np.asarray(np.linalg.norm(corners[:, 0] - corners[:, 1], axis=1))


_LAYOUT: Layout = {
    "rate": real(low=1e-9),
    "seed": whole(),
    **dict.fromkeys(("person", "sentence", "command"), text()),
    "unit_names": text("U"),
    "unit_weights": real("T", "U"),
    "identity_weights": real("K*", dtype=np.float32),
    "neutral": real("V", 3, dtype=np.float32),
    "faces": index("V", "F", 3),
    "facet_class": index("C", "F", dtype=np.uint8),
    "class_names": text("C"),
    "uv": real("V", 2, dtype=np.float32),
    **dict.fromkeys(("rotations", "translations"), real("T", 3)),
    "phonemes": text("T"),
    "phoneme_label": text("I*"),
    **dict.fromkeys(("phoneme_start", "phoneme_end"), real("I*")),
    "closed": truth("T"),
    "gap": real("T"),
    "outer_lip": index("V", "outer"),
    "outer_lip_20": index("V", "lips"),
    "inner_lip_8": index("V", 8),
    "mouth_corners": index("V", 2),
    "landmark_68": index("V", 68),
}


def load_clip(folder: Path) -> Clip:
    """Read the ``truth.npz`` of a clip's folder; the vertex offsets are read when wanted.

    Raises
    ------
    InputFileError
        If it is missing or cannot be read.
    ModelFormatError
        If it has another format or version, or lacks an array.
    """
    path = folder / TRUTH
    data = plain(read_npz(path, FORMAT, VERSION, _LAYOUT, AGAIN))
    labels = data.pop("phoneme_label")
    times = (data.pop(f"phoneme_{n}").tolist() for n in ("start", "end"))
    rotations = data.pop("rotations")
    return Clip(
        name=folder.name,
        world_rotations=rotations,
        world_translations=data.pop("translations"),
        intervals=tuple(Phoneme(*row) for row in zip(labels, *times, strict=True)),
        landmarks={name: data.pop(name) for name in LANDMARKS},
        offsets=StoredOffsets(folder, len(rotations), len(data["neutral"])),
        **data,
    )
