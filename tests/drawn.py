"""Bundled people in postures, drawn by the CPU rasteriser, and landmarks made without a network."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache, lru_cache
from pathlib import Path

import cv2
import numpy as np
from heads import SIZE, lit_picture_of, picture_of, seen_at
from runs import write_kind

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Scene
from abs_engine.face.identity import head_modes
from abs_engine.face.settings.shape import SHAPE
from abs_engine.face.shape.linear import LinearShape
from abs_engine.face.shape.mouth import mouth_shape
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.tracking.detection.face_detection import find_face
from abs_engine.tracking.detection.landmarks import Landmarks, landmarks_of
from abs_engine.tracking.head.head_fit import landmark_shape
from abs_engine.tracking.landmark.landmark_correspondence import Correspondence, load_correspondence
from abs_engine.tracking.landmark.landmark_shape import LandmarkShape

CAMERA = Camera.ideal(SIZE)
OPEN = (0.0, 0.1, 0.25, 0.35, 0.15)
"""How far the mouth of a film is open, by `jawOpen`."""
AHEAD = seen_at([0, 0, 0], [0, 0, 700])


@cache
def speaker() -> Speaker:
    """The bundled speaker."""
    return load_speaker()


@cache
def correspondence() -> Correspondence:
    """Where landmarks lie on the bundled speaker."""
    found = load_correspondence(speaker())
    assert found is not None
    return found


@cache
def texture_of(person: str) -> np.ndarray:
    """The texture (H, W, 3) of a person."""
    return speaker().texture(person)


def vertices_of(person: str | None, **units: float) -> np.ndarray:
    """A person (V, 3), by default the average one, mm, in a posture by weights of face units."""
    one = speaker()
    neutral = one.vertices if person is None else one.named(person)
    moved = np.tensordot(np.array(list(units.values())), one.unit_matrix(tuple(units)), 1)
    return neutral.astype(np.float64) + moved


def scene_of(person: str, **units: float) -> Scene:
    """A person's whole head in a posture."""
    one, vertices = speaker(), vertices_of(person, **units)
    return Scene(
        vertices, np.zeros((0, *vertices.shape)), one.faces, one.uv, one.facet_class,
        texture_of(person),
    )  # fmt: skip


@dataclass(frozen=True)
class View:
    """A pose and a camera that are the same as others of the same numbers."""

    numbers: tuple[bytes, ...]
    size: tuple[int, int]
    pose: Pose = field(compare=False)
    camera: Camera = field(compare=False)

    @classmethod
    def of(cls, pose: Pose, camera: Camera) -> View:
        arrays = pose.rotation, pose.translation, camera.matrix, camera.distortion
        return cls(tuple(one.tobytes() for one in arrays), camera.size, pose, camera)


@lru_cache(100)
def _drawn(person: str, view: View, lamp: bool, units: tuple[tuple[str, float], ...]) -> np.ndarray:
    head = scene_of(person, **dict(units))
    if lamp:
        return lit_picture_of(head, view.pose, view.camera, (0.3, -0.5, -1.0), 0.0)
    return picture_of(head, view.pose, view.camera)


def drawn(person: str, pose: Pose = AHEAD, camera: Camera = CAMERA, **units: float) -> np.ndarray:
    """A picture (H, W, 3) uint8 of a person in a posture."""
    return _drawn(person, View.of(pose, camera), False, tuple(units.items())).copy()


def lit(person: str, pose: Pose = AHEAD, camera: Camera = CAMERA, **units: float) -> np.ndarray:
    """The same under a lamp above the camera's side."""
    return _drawn(person, View.of(pose, camera), True, tuple(units.items())).copy()


@cache
def average_shape() -> LinearShape:
    """How the average head's mouth moves."""
    return mouth_shape(speaker(), speaker().vertices, SHAPE.expression_modes)


@cache
def anybody() -> LandmarkShape:
    """The landmarks of anybody's head."""
    one = speaker()
    return landmark_shape(one, correspondence(), average_shape(), one.vertices, head_modes(one))


def network_sees(image: np.ndarray) -> Landmarks:
    """The landmarks of the face in a picture, which must be seen."""
    face = find_face(image)
    assert face is not None
    seen = landmarks_of(image, face)
    assert seen is not None
    return seen


def projected(
    points: np.ndarray, pose: Pose, camera: Camera = CAMERA, noise: float = 0.0, seed: int = 0
) -> Landmarks:
    """Landmarks as a network would see points (468, 3), mm, if it erred by `noise` mm."""
    there = pose.apply(points)
    off = np.random.default_rng(seed).normal(0, noise, there.shape) if noise else 0.0
    pixel = there[:, 2].mean() / camera.matrix[0, 0]
    depth = (there[:, 2] - there[:, 2].mean()) / pixel
    at = np.column_stack([camera.project(there), depth])
    return Landmarks(at + off / pixel, 1.0)


def turned_by(one: Pose, other: Pose) -> float:
    """Angle between the rotations of two poses, degrees."""
    between = Pose(one.rotation @ other.rotation.T, np.zeros(3))
    return float(np.degrees(np.linalg.norm(between.rotation_vector)))


def film(path: Path, frames: int = 5, *, grey: bool = False, factor: float = 1.0) -> Path:
    """Some frames of a drawn head that opens its mouth and turns a little."""
    pictures = []
    for k, amount in enumerate(OPEN[:frames]):
        pose = seen_at([0, 0.05 * k - 0.1, 0], [0, 0, 700])
        picture = lit("amara", pose, jawOpen=amount)
        if factor != 1:
            picture = cv2.resize(picture, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
            picture = cv2.copyMakeBorder(
                picture, 20, 20, 30, 30, cv2.BORDER_CONSTANT, value=(100, 100, 100)
            )
            picture = picture[: picture.shape[0] // 2 * 2, : picture.shape[1] // 2 * 2]
        if grey:
            picture = np.repeat(picture.mean(axis=2, keepdims=True), 3, axis=2).astype(np.uint8)
        pictures.append(picture)
    return write_kind(path, "libx264", pictures)
