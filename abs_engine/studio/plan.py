"""The plan of a film, worked out to the last frame: the form in which processes get a clip.

The world frame is the head's at rest (x to the subject's left, y up, z out of the face), mm.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.dataset.codec import BOARD, HAND, MICROPHONE
from abs_engine.io.naming import settle
from abs_engine.io.npz import read_npz
from abs_engine.studio.appearance.optics import Background, Sensor

FORMAT, VERSION = "abs_engine.plan", 1


@dataclass(frozen=True, eq=False)
class Prop:
    """A thing in front of the head, such as a hand.

    Parameters
    ----------
    code : int
        See `abs_engine.dataset.codec.COVER_NAMES`.
    vertices : (N, 3) float32, mm, own frame
    faces : (M, 3) int32
    normals : (N, 3) float32
    colour : (N, 3) float32, linear RGB
    rotations, translations : (T, 3) float64
        Own frame to world, rotation vectors and mm.
    present : (T,) bool
        Whether it is there.
    """

    code: int
    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    normals: NDArray[np.float32]
    colour: NDArray[np.float32]
    rotations: FloatArray
    translations: FloatArray
    present: BoolArray


@dataclass(frozen=True, eq=False)
class View:
    """A camera of a clip.

    Parameters
    ----------
    rotations, translations : (T, 3) or (1, 3) float64
        World to camera; one row where the camera stands still.
    gain : (T,) float64
        Exposure.
    blur : (T,) float64
        Blur beyond the lens's own, pixels.
    crf : int
        x264's quality of ``io.video.mp4``; 0 is without loss.
    mirror : (4, 3) float64, optional
        Corners of a mirror, camera frame, mm.
    """

    name: str
    camera: Camera
    rotations: FloatArray
    translations: FloatArray
    gain: FloatArray
    blur: FloatArray
    sensor: Sensor = field(default_factory=Sensor)
    background: Background = field(default_factory=Background)
    crf: int = 16
    mirror: FloatArray | None = None

    def pose(self, frame: int) -> Pose:
        """World to camera in a frame."""
        row = frame if len(self.rotations) > 1 else 0
        return Pose.from_vectors(self.rotations[row], self.translations[row])


@dataclass(frozen=True, eq=False)
class ClipPlan:
    """A clip: one person, in all its frames, before all its cameras.

    Parameters
    ----------
    seed : int
        Of the sensors' noise, with `number` and the numbers of camera and frame.
    number : int
        The clip's place in the data set.
    rate : float
        Frames per second.
    weights : (T, 52) float64, face units
    identity_weights : (K,) float32
    neutral : (V, 3) float32, mm, head frame
    texture : (S, S, 3) uint8
    dots : (N,) int32
        Vertices on which dots are painted.
    rotations, translations : (T, 3) float64
        Head to world, rotation vectors and mm.
    phonemes : tuple of str
        One for each frame.
    intervals : tuple of (str, float, float)
        Label, start and end in seconds.
    lights : (T, L, 7) float64
        Direction of travel in the world, intensity, RGB.
    props : tuple of Prop
        The shirt first, if there is one.
    """

    name: str
    person: str
    sentence: str
    command: str
    seed: int
    number: int
    rate: float
    weights: FloatArray
    identity_weights: NDArray[np.float32]
    neutral: NDArray[np.float32]
    texture: NDArray[np.uint8]
    dots: NDArray[np.int32]
    rotations: FloatArray
    translations: FloatArray
    phonemes: tuple[str, ...]
    intervals: tuple[tuple[str, float, float], ...]
    lights: FloatArray
    ambient: float
    roughness: float
    views: tuple[View, ...]
    props: tuple[Prop, ...]

    def __len__(self) -> int:
        """Return the number of frames, T."""
        return len(self.weights)

    @cached_property
    def occluders(self) -> bool:
        """Whether a hand, a microphone or a board belongs to the clip."""
        return any(prop.code in (HAND, MICROPHONE, BOARD) for prop in self.props)

    def head(self, frame: int) -> Pose:
        """Head to world in a frame."""
        return Pose.from_vectors(self.rotations[frame], self.translations[frame])

    def pose(self, view: View, frame: int) -> Pose:
        """Head to camera in a frame."""
        return compose(view.pose(frame), self.head(frame))


def compose(outer: Pose, inner: Pose) -> Pose:
    """The pose that does `inner` first, then `outer`."""
    return Pose(outer.rotation @ inner.rotation, outer.apply(inner.translation))


def vectors(poses: list[Pose]) -> tuple[FloatArray, FloatArray]:
    """Rotation vectors and translations (T, 3) of poses."""
    rotations = np.array([pose.rotation_vector for pose in poses])
    return rotations, np.array([pose.translation for pose in poses])


_SMALL = (
    "name", "person", "sentence", "command", "seed", "number", "rate", "phonemes", "intervals",
    "ambient", "roughness",
)  # fmt: skip
_ARRAYS = (
    "weights", "identity_weights", "neutral", "texture", "dots", "rotations", "translations",
    "lights",
)  # fmt: skip
_PROP = ("vertices", "faces", "normals", "colour", "rotations", "translations", "present")
_VIEW = ("rotations", "translations", "gain", "blur")


def store(plan: ClipPlan, path: Path) -> None:
    """Write a plan as NPZ, for film processes."""
    told = {name: getattr(plan, name) for name in _SMALL}
    told["views"] = [_view_text(view) for view in plan.views]
    told["props"] = [prop.code for prop in plan.props]
    arrays: dict[str, Any] = {name: getattr(plan, name) for name in _ARRAYS}
    for number, view in enumerate(plan.views):
        arrays |= {f"view{number}_{name}": getattr(view, name) for name in _VIEW}
        if view.mirror is not None:
            arrays[f"view{number}_mirror"] = view.mirror
    for number, prop in enumerate(plan.props):
        arrays |= {f"prop{number}_{name}": getattr(prop, name) for name in _PROP}
    arrays |= {"format": FORMAT, "version": VERSION, "told": json.dumps(told)}
    made = path.with_name(f".{path.name}")
    np.savez(made, **arrays)
    settle(made)
    os.replace(made, path)


def _view_text(view: View) -> dict[str, Any]:
    camera = view.camera
    return {
        "name": view.name,
        "crf": view.crf,
        "sensor": asdict(view.sensor),
        "background": asdict(view.background),
        "matrix": camera.matrix.tolist(),
        "size": list(camera.size),
        "distortion": camera.distortion.tolist(),
        "near": camera.near,
        "far": camera.far,
    }


def load(path: Path) -> ClipPlan:
    """Read what `store` wrote.

    Raises
    ------
    InputFileError, ModelFormatError
        If it is missing, cut or of another version.
    """
    data: Mapping[str, Any] = read_npz(path, FORMAT, VERSION)
    told = json.loads(str(data["told"]))
    views = tuple(_view(text, data, number) for number, text in enumerate(told.pop("views")))
    props = tuple(
        Prop(code, **{name: data[f"prop{number}_{name}"] for name in _PROP})
        for number, code in enumerate(told.pop("props"))
    )
    told["phonemes"] = tuple(told["phonemes"])
    told["intervals"] = tuple((str(a), float(b), float(c)) for a, b, c in told["intervals"])
    arrays = {name: data[name] for name in _ARRAYS}
    return ClipPlan(**told, **arrays, views=views, props=props)


def _view(text: dict[str, Any], data: Mapping[str, Any], number: int) -> View:
    width, height = text["size"]
    camera = Camera(
        np.array(text["matrix"]), (width, height), np.array(text["distortion"]),
        text["near"], text["far"],
    )  # fmt: skip
    behind: dict[str, Any] = {
        k: tuple(v) if isinstance(v, list) else v for k, v in text["background"].items()
    }
    return View(
        name=text["name"],
        camera=camera,
        sensor=Sensor(**text["sensor"]),
        background=Background(**behind),
        crf=text["crf"],
        mirror=data.get(f"view{number}_mirror"),
        **{name: data[f"view{number}_{name}"] for name in _VIEW},
    )
