"""The plan of a film, worked out to the last frame: the form in which processes get a clip.

The world frame is the head's at rest (x to the subject's left, y up, z out of the face), mm.
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field, fields, is_dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose, compose
from abs_engine.dataset.codec import BOARD, HAND, MICROPHONE
from abs_engine.io.naming import settle
from abs_engine.io.npz import read_npz
from abs_engine.studio.appearance.optics import Background, Sensor

FORMAT, VERSION = "abs_engine.plan", 2


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


def store(plan: ClipPlan, path: Path) -> None:
    """Write a plan as NPZ, for film processes: JSON, in which names stand for the arrays."""
    arrays: dict[str, Any] = {}

    def told(value: Any) -> Any:
        if isinstance(value, np.ndarray):
            name = f"array{len(arrays)}"
            arrays[name] = value
            return {"array": name}
        if is_dataclass(value):
            return {one.name: told(getattr(value, one.name)) for one in fields(value)}
        return list(map(told, value)) if isinstance(value, tuple) else value

    text = json.dumps(told(plan))
    made = path.with_name(f".{path.name}")
    np.savez(made, format=FORMAT, version=VERSION, told=text, **arrays)
    settle(made)
    os.replace(made, path)


def load(path: Path) -> ClipPlan:
    """Read what `store` wrote.

    Raises
    ------
    InputFileError, ModelFormatError
        If it is missing, cut or of another version.
    """
    data = read_npz(path, FORMAT, VERSION)

    def filled(table: dict[str, Any]) -> Any:
        return data[table["array"]] if "array" in table else table

    told = json.loads(str(data["told"]), object_hook=filled)
    views = tuple(_view(**view) for view in told.pop("views"))
    props = tuple(Prop(**prop) for prop in told.pop("props"))
    phonemes, intervals = tuple(told.pop("phonemes")), tuple(map(tuple, told.pop("intervals")))
    return ClipPlan(**told, phonemes=phonemes, intervals=intervals, views=views, props=props)


def _view(
    camera: dict[str, Any], sensor: dict[str, Any], background: dict[str, Any], **more: Any
) -> View:
    behind: dict[str, Any] = {
        k: tuple(v) if isinstance(v, list) else v for k, v in background.items()
    }
    return View(
        camera=Camera(**camera), sensor=Sensor(**sensor), background=Background(**behind), **more
    )
