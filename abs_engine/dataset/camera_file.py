"""``camera.json``: a camera's intrinsics and distortion, where it stands, and its mirror."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import WIDEST_SIDE, Camera
from abs_engine.core.errors import InputFileError, ModelFormatError, ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.dataset.codec import CAMERA_FORMAT, VERSION
from abs_engine.io.arrays import Layout, check_arrays, of_json, real, whole
from abs_engine.io.inputs import check_file, read_json

MEND = (
    "a camera file is JSON with format, version, size [w, h], matrix (3 rows, px), distortion "
    "(a list), near and far (mm), as `abs-engine synth` writes it for each camera"
)
"""What to do about a bad file, whoever wrote it."""

_DEPTHS = ("near", "far")
_LAYOUT: Layout = {
    "size": whole(2, low=1, high=WIDEST_SIDE),
    "matrix": real(3, 3),
    "distortion": real("K*"),
    **dict.fromkeys(_DEPTHS, real()),
    **dict.fromkeys(("rotations", "translations"), real("N", 3, optional=True)),
    "rectangle": real(4, 3, optional=True),
}


@dataclass(frozen=True, eq=False)
class PlacedCamera:
    """A camera and where it stands.

    Parameters
    ----------
    rotations : (N, 3) float64
        Rotation vectors, world to camera, radians; N is 1 where the camera stands still, else the
        number of frames.
    translations : (N, 3) float64, mm, camera frame
    mirror : (4, 3) float64, mm, camera frame, optional
        Corners of a plane mirror that stands still before the camera.
    """

    camera: Camera
    rotations: FloatArray
    translations: FloatArray
    mirror: FloatArray | None

    @property
    def at_origin(self) -> bool:
        """Whether it stands still and the world is its own frame, as a pair's first camera's is."""
        return len(self.rotations) == 1 and not (self.rotations.any() or self.translations.any())

    def pose(self, frame: int) -> Pose:
        """World to camera in a frame."""
        at = 0 if len(self.rotations) == 1 else frame
        return Pose.from_vectors(self.rotations[at], self.translations[at])


def camera_json(
    camera: Camera,
    rotations: ArrayLike | None = None,
    translations: ArrayLike | None = None,
    mirror: ArrayLike | None = None,
) -> str:
    """The text of a ``camera.json``; see `PlacedCamera` for what its parts are."""
    fields = {
        "format": CAMERA_FORMAT,
        "version": VERSION,
        "size": list(camera.size),
        "matrix": camera.matrix.tolist(),
        "distortion": camera.distortion.tolist(),
        "near": camera.near,
        "far": camera.far,
        "rotations": _rows(rotations),
        "translations": _rows(translations),
    }
    if mirror is not None:
        fields["mirror"] = {"rectangle": np.asarray(mirror, np.float64).reshape(4, 3).tolist()}
    return json.dumps(fields, indent=1) + "\n"


def _rows(vectors: ArrayLike | None) -> list[list[float]]:
    given = np.zeros((1, 3)) if vectors is None else np.asarray(vectors, np.float64)
    rows: list[list[float]] = given.reshape(-1, 3).tolist()
    return rows


def load_camera(path: Path) -> Camera:
    """Read the intrinsics and the distortion of a ``camera.json``.

    Errors are those of `load_placed_camera`.
    """
    return load_placed_camera(path).camera


def load_placed_camera(path: Path) -> PlacedCamera:
    """Read a ``camera.json``; one without `rotations` stands at the origin of the world.

    Raises
    ------
    InputFileError
        If it is missing or no JSON.
    ModelFormatError
        If it has another format or version, or lacks a field.
    ParameterError
        If there can be no such camera.
    """
    path = Path(path)
    check_file(path)
    try:
        return _parse(path, read_json(path))
    except KeyError as error:
        raise ModelFormatError(f"{path} lacks the field {error}", MEND) from error
    except (TypeError, IndexError, AttributeError) as error:
        raise ModelFormatError(f"{path} has a field with a wrong value ({error})", MEND) from error
    except ParameterError as error:
        raise ParameterError(f"{path}: {error.problem}", error.remedy) from error
    except ValueError as error:
        raise InputFileError(f"{path} is not a camera file ({error})", MEND) from error


def _parse(path: Path, fields: dict[str, Any]) -> PlacedCamera:
    kind = fields["format"], fields["version"]
    if kind != (CAMERA_FORMAT, VERSION):
        raise ModelFormatError(
            f"{path} is {kind[0]} version {kind[1]}, wanted {CAMERA_FORMAT} {VERSION}", MEND
        )
    if "mirror" in fields:
        fields = {"rectangle": fields["mirror"]["rectangle"], **fields}
    given = {name: of_json(value) for name, value in fields.items() if name in _LAYOUT}
    data = check_arrays(path, given, _LAYOUT, MEND)
    width, height = data["size"].tolist()
    camera = Camera(
        data["matrix"], (width, height), data["distortion"], *(data[k].item() for k in _DEPTHS)
    )
    if ("rotations" in data) != ("translations" in data):
        raise ModelFormatError(
            f"{path} has rotations or translations without the others",
            "give as many of both, one where the camera stands still, or leave both out",
        )
    still = np.zeros((1, 3))
    rotations, translations = (data.get(k, still) for k in ("rotations", "translations"))
    return PlacedCamera(camera, rotations, translations, data.get("rectangle"))
