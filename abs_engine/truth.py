"""Ground truth of a filmed clip: its type, its file layout, and the only reader of it.

A folder holds ``video.mp4``; ``truth.npz`` (every array is listed in `Truth`); ``camera.json``;
``ids/NNNNNN.png``, 16 bit, facet index + 1, 0 where the head is not seen; ``depth/NNNNNN.png``,
16 bit, distance along the optical axis in steps of `DEPTH_STEP` mm, 0 where the head is not seen;
and ``SHA256SUMS`` of all of them, as the command ``sha256sum -c`` reads it. Ids and depth are
taken at pixel centres, one sample each.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.assets import read_npz
from abs_engine.camera import Camera
from abs_engine.errors import InputFileError, ModelFormatError, ParameterError
from abs_engine.geometry import Pose

FloatArray = NDArray[np.float64]

FORMAT, CAMERA_FORMAT, VERSION = "abs_engine.truth", "abs_engine.camera", 1
DEPTH_STEP = 0.05
SUMS = "SHA256SUMS"
_AGAIN = "film it again, or copy the whole folder again"
_FIELDS: dict[str, Callable[[Any], Any]] = {
    "rate": float,
    "seed": int,
    **dict.fromkeys(("person", "sentence", "command"), str),
    **dict.fromkeys(("unit_names", "class_names", "visemes"), lambda a: tuple(map(str, a))),
    **dict.fromkeys(("unit_weights", "identity_weights", "neutral", "offsets"), np.asarray),
    **dict.fromkeys(("faces", "facet_class", "rotations", "translations", "closed"), np.asarray),
}
_LANDMARKS = ("outer_lip", "outer_lip_20", "inner_lip_8", "mouth_corners")


@dataclass(frozen=True, eq=False)
class Truth:
    """What is true of every frame of a clip.

    Lengths in mm. Arrays as in ``truth.npz``, which adds `format` and `version`, and stores
    `landmarks` under their own names.

    Parameters
    ----------
    folder : Path
    camera : Camera
    rate : float
        Frames per second.
    person, sentence, command : str
        Who is filmed, what is said, and the command that filmed it.
    seed : int
    unit_names : tuple of str
    unit_weights : (T, 52) float64
    identity_weights : (K,) float32
    neutral : (V, 3) float32, head frame
        The person at rest.
    offsets : (T, V, 3) float16, head frame
        What was filmed is exactly neutral + offsets.
    faces : (F, 3) int32
    facet_class : (F,) uint8, index into `class_names`
    class_names : tuple of str
    rotations : (T, 3) float64
        Rotation vectors, head to camera, radians. Compare rotations as matrices: near half a
        turn, where faces look into the camera, two opposite vectors mean the same.
    translations : (T, 3) float64, camera frame
    visemes : tuple of str
        One for each frame.
    closed : (T,) bool
        The lips touch all along, measured on the mesh.
    landmarks : mapping of str to int32 vertex indices
        outer_lip, outer_lip_20, inner_lip_8, mouth_corners.
    """

    folder: Path
    camera: Camera
    rate: float
    person: str
    sentence: str
    command: str
    seed: int
    unit_names: tuple[str, ...]
    unit_weights: FloatArray
    identity_weights: NDArray[np.float32]
    neutral: NDArray[np.float32]
    offsets: NDArray[np.float16]
    faces: NDArray[np.int32]
    facet_class: NDArray[np.uint8]
    class_names: tuple[str, ...]
    rotations: FloatArray
    translations: FloatArray
    visemes: tuple[str, ...]
    closed: NDArray[np.bool_]
    landmarks: Mapping[str, NDArray[np.int32]]

    def __len__(self) -> int:
        """Return the number of frames, T."""
        return len(self.offsets)

    def vertices(self, frame: int) -> NDArray[np.float32]:
        """Vertices (V, 3), mm, head frame, in a frame."""
        return np.asarray(self.neutral + self.offsets[frame].astype(np.float32), np.float32)

    def pose(self, frame: int) -> Pose:
        """Head to camera in a frame."""
        return Pose.from_vectors(self.rotations[frame], self.translations[frame])

    def points(self, vertex: NDArray[np.integer]) -> FloatArray:
        """The paths (T, N, 3), mm, head frame, of some vertices (N,)."""
        return np.asarray(self.neutral[vertex] + self.offsets[:, vertex].astype(np.float64))

    def pixels(self, frame: int, vertex: NDArray[np.integer]) -> FloatArray:
        """Where vertices (N,) lie in the picture, (N, 2), seen or not."""
        points = self.vertices(frame)[vertex].astype(np.float64)
        return self.camera.project(self.pose(frame).apply(points))

    @cached_property
    def aperture(self) -> FloatArray:
        """Height (T,), mm, between the inner lips in the middle; 0 where they overlap.

        y of point 62 less y of point 66 of the 68 (`inner_lip_8` 2 and 6), head frame.
        """
        inner = self.points(self.landmarks["inner_lip_8"])
        return np.asarray(np.maximum(inner[:, 2, 1] - inner[:, 6, 1], 0.0))

    @cached_property
    def width(self) -> FloatArray:
        """Distance (T,), mm, between the outer corners of the mouth."""
        corners = self.points(self.landmarks["mouth_corners"])
        return np.asarray(np.linalg.norm(corners[:, 0] - corners[:, 1], axis=1))

    def facet_ids(self, frame: int) -> NDArray[np.uint16]:
        """Facet index + 1 of each pixel, (H, W); 0 where the head is not seen."""
        return self._image("ids", frame)

    def class_ids(self, frame: int) -> NDArray[np.uint8]:
        """Class id of each pixel, (H, W), an index into `class_names`; 0 is the background."""
        table = np.concatenate([[0], self.facet_class]).astype(np.uint8)
        return np.asarray(table[self.facet_ids(frame)], np.uint8)

    def depth(self, frame: int) -> NDArray[np.float32]:
        """Depth of each pixel, (H, W), mm along the optical axis; 0 where the head is not seen."""
        return np.asarray(self._image("depth", frame) * np.float32(DEPTH_STEP), np.float32)

    def _image(self, kind: str, frame: int) -> NDArray[np.uint16]:
        if not 0 <= frame < len(self):
            raise ParameterError(f"there is no frame {frame}", f"give 0 to {len(self) - 1}")
        path = self.folder / kind / f"{frame:06d}.png"
        image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED) if path.is_file() else None
        if image is None or image.dtype != np.uint16 or image.shape[::-1] != self.camera.size:
            raise InputFileError(f"{path} is missing or no 16-bit picture of the clip", _AGAIN)
        return np.asarray(image, np.uint16)


def load_truth(folder: Path, *, verify: bool = False) -> Truth:
    """Read the ground truth of a clip.

    Parameters
    ----------
    folder : Path
    verify : bool
        Check every file against its checksum; otherwise only ``truth.npz``, ``camera.json``
        and that the video is there.

    Raises
    ------
    InputFileError
        If a file is missing or cannot be read.
    ModelFormatError
        If a file was altered, or has another format or version.
    """
    folder = Path(folder)
    check_sums(folder, None if verify else ("truth.npz", "camera.json"))
    if not (folder / "video.mp4").is_file():
        raise InputFileError(f"{folder / 'video.mp4'} does not exist", _AGAIN)
    data: Mapping[str, Any] = read_npz(folder / "truth.npz", FORMAT, VERSION)
    try:
        fields = {name: convert(data[name]) for name, convert in _FIELDS.items()}
        landmarks = {name: data[name] for name in _LANDMARKS}
        camera = load_camera(folder / "camera.json")
        return Truth(folder=folder, camera=camera, landmarks=landmarks, **fields)
    except KeyError as error:
        raise ModelFormatError(f"{folder / 'truth.npz'} lacks {error}", _AGAIN) from error


def check_sums(folder: Path, only: tuple[str, ...] | None = None) -> None:
    """Compare files of a folder with its ``SHA256SUMS``.

    Parameters
    ----------
    folder : Path
    only : tuple of str, optional
        Names of the files to check, by default all that are listed.

    Raises
    ------
    InputFileError
        If the list or a file is missing.
    ModelFormatError
        If a file differs from what was written, or is not listed.
    """
    listed = folder / SUMS
    if not listed.is_file():
        raise InputFileError(f"{folder} is no ground truth: {SUMS} is missing", "check the path")
    lines = listed.read_text(encoding="utf-8", errors="replace").splitlines()
    sums = {name: digest for digest, _, name in (line.partition("  ") for line in lines)}
    for name in sums if only is None else only:
        path = folder / name
        if not path.is_file():
            raise InputFileError(f"{path} does not exist", _AGAIN)
        if hashlib.sha256(path.read_bytes()).hexdigest() != sums.get(name):
            raise ModelFormatError(f"{path} was altered after it was written", _AGAIN)


def camera_json(camera: Camera) -> str:
    """A camera as the text of a ``camera.json``."""
    fields = {
        "format": CAMERA_FORMAT,
        "version": VERSION,
        "size": list(camera.size),
        "matrix": camera.matrix.tolist(),
        "distortion": camera.distortion.tolist(),
        "near": camera.near,
        "far": camera.far,
    }
    return json.dumps(fields, indent=1) + "\n"


def load_camera(path: Path) -> Camera:
    """Read a ``camera.json``: size (w, h), matrix 3x3, distortion (8) as OpenCV's, near and far.

    Raises
    ------
    InputFileError
        If it is missing or no JSON.
    ModelFormatError
        If it has another format or version, or lacks a field.
    """
    if not path.is_file():
        raise InputFileError(f"{path} does not exist", "check the path")
    try:
        fields = json.loads(path.read_text(encoding="utf-8"))
        kind = fields["format"], fields["version"]
        if kind != (CAMERA_FORMAT, VERSION):
            raise ModelFormatError(
                f"{path} is {kind[0]} version {kind[1]}, wanted {CAMERA_FORMAT} {VERSION}", _AGAIN
            )
        width, height = (int(n) for n in fields["size"])
        matrix, distortion = (np.array(fields[k], np.float64) for k in ("matrix", "distortion"))
        return Camera(
            matrix, (width, height), distortion, float(fields["near"]), float(fields["far"])
        )
    except (KeyError, TypeError, IndexError) as error:
        raise ModelFormatError(
            f"{path} lacks a field or has a wrong one ({error})", _AGAIN
        ) from error
    except ValueError as error:
        raise InputFileError(f"{path} is not a camera file", _AGAIN) from error
