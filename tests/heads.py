"""The bundled head, drawn by the CPU rasteriser before a plain wall."""

from __future__ import annotations

import cv2
import numpy as np

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import FACING, Pose, vertex_normals
from abs_engine.core.scene import Candidates, Scene
from abs_engine.face.appearance.chroma import sampled
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colour_learning import learn_classes
from abs_engine.face.head import MouthModel
from abs_engine.fit.head_frame import mouth_window
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.detection.face_detection import Face
from abs_engine.tracking.start.blob_start import mouth_model

SIZE = 320, 240


def head_of(person: str) -> MouthModel:
    """The mouth model of a person whose head is known."""
    return mouth_model(load_speaker(), person)


def spoken_heads(speaker: Speaker, neutral: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """All vertices (V, M, 3), mm, head frame, at face-unit weights (V, 52)."""
    used = np.flatnonzero(weights.any(axis=0))
    moved = np.tensordot(
        weights[:, used].astype(np.float32), speaker.units[used].astype(np.float32), 1
    )
    return np.asarray(neutral + moved, np.float32)


def picture_of(head: Scene, pose: Pose, camera: Camera) -> np.ndarray:
    """A picture (H, W, 3) uint8 of a head, twice as fine and averaged."""
    window = type(camera.whole)(0, 0, *camera.size, 2.0)
    one = Candidates.one(np.zeros(head.n_modes), pose)
    buffers = CpuRenderer().draw(head, one, camera, window)[0]
    rows = np.linspace(120, 80, buffers.rgb.shape[0])[:, None, None]
    fine = np.where(buffers.covered[..., None], buffers.rgb, rows)
    return np.uint8(np.rint(cv2.resize(fine, camera.size, interpolation=cv2.INTER_AREA)))


def lit_picture_of(
    head: Scene, pose: Pose, camera: Camera, lamp: tuple[float, float, float], gloss: float
) -> np.ndarray:
    """A picture of a head under a lamp, with white gloss of up to `gloss` grey levels.

    `lamp` is the direction to it in the camera frame; right above the camera it is 0, -1, -1.
    """
    window = type(camera.whole)(0, 0, *camera.size, 2.0)
    one = Candidates.one(np.zeros(head.n_modes), pose)
    buffers = CpuRenderer().draw(head, one, camera, window)[0]
    seen = buffers.covered  # a head fills a quarter of a picture: the rest is not shaded
    normals = vertex_normals(head.mean.astype(np.float64), head.faces)
    corners, share = head.faces[buffers.facet_id[seen] - 1], buffers.barycentrics[seen]

    def towards(direction: np.ndarray) -> np.ndarray:
        """Cosine of each pixel's normal and a direction in the camera frame, 0 beyond."""
        at_vertices = normals @ pose.rotation.T @ (direction / np.linalg.norm(direction))
        return np.clip((share * at_vertices[corners]).sum(axis=1), 0, None)

    to_lamp = np.array(lamp) / np.linalg.norm(lamp)
    matt = 0.35 + 0.75 * towards(to_lamp)
    shine = gloss * np.minimum(towards(to_lamp - np.array([0, 0, 1])), 1) ** 24
    fine = np.full(buffers.rgb.shape, 100.0)
    fine[seen] = buffers.rgb[seen] * matt[:, None] + shine[:, None]
    small = cv2.resize(fine, camera.size, interpolation=cv2.INTER_AREA)
    return np.uint8(np.rint(np.clip(small, 0, 255)))


def face_of(marks: np.ndarray, pose: Pose, camera: Camera) -> Face:
    """The face whose eyes, nose and mouth (4, 3) a detector sees where they are."""
    points = np.zeros((6, 2))
    points[:4] = camera.project(pose.apply(marks))
    return Face(points[:4].mean(axis=0), 100.0, points, 1.0)


def seen_at(rotation: object, translation: object) -> Pose:
    """A head turned by a rotation vector (radians, camera axes) away from facing the camera."""
    turned = Pose.from_vectors(rotation, translation)
    return Pose(turned.rotation @ FACING, turned.translation)


def colours_of(model: MouthModel, pose: Pose, camera: Camera) -> ColourClasses:
    """The colour classes of a person, learned from where they are drawn."""
    one = Candidates.one(np.zeros(model.head.n_modes), pose)
    window = mouth_window(model, pose, camera)
    drawn = CpuRenderer().draw(model.head, one, camera, window)[0].class_id
    shows = np.array([{"skin": 0, "lips": 1, None: 3}.get(c, 2) for c in model.colour_classes])
    places = np.stack([shows[drawn] == k for k in range(3)]) * (drawn > 0) * 0.95
    return learn_classes([sampled(window, picture_of(model.head, pose, camera))], [places])
