"""Drawings of a head from several sides, as the landmark network sees them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import cv2
import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Camera, Window
from abs_engine.core.geometry import FACING, Pose, rotations, vertex_normals
from abs_engine.core.scene import Candidates, Renderer, Scene
from abs_engine.io.assets import Speaker
from abs_engine.tracking.face_detection import find_face
from abs_engine.tracking.landmark_correspondence import Sighting
from abs_engine.tracking.landmarks import landmarks_of
from abs_engine.tracking.settings.landmarks import LANDMARK_EVIDENCE


@dataclass(frozen=True, eq=False)
class Light:
    """Light of a drawing.

    Parameters
    ----------
    lamp : (3,) float64
        Direction to it, camera frame.
    ambient, diffuse : float
        Light of the room, and of the lamp.
    wall : float
        Grey of the wall behind the head.
    tint : (3,) float64
        Colour of all light.
    """

    lamp: FloatArray
    ambient: float = LANDMARK_EVIDENCE.drawn_ambient
    diffuse: float = LANDMARK_EVIDENCE.drawn_diffuse
    wall: float = LANDMARK_EVIDENCE.drawn_wall
    tint: FloatArray | float = 1.0


USUAL_LIGHT = Light(np.array(LANDMARK_EVIDENCE.drawn_lamp))


def sightings_of(
    speaker: Speaker, vertices: FloatArray, texture: Image, renderer: Renderer
) -> Iterator[Sighting]:
    """Sightings by the network of a head (V, 3), mm, from those sides on which it sees one."""
    camera = Camera.ideal((LANDMARK_EVIDENCE.drawn_side, LANDMARK_EVIDENCE.drawn_side))
    place = np.array([0.0, 0.0, LANDMARK_EVIDENCE.drawn_depth])
    for pitch, yaw in product(LANDMARK_EVIDENCE.drawn_pitches, LANDMARK_EVIDENCE.drawn_yaws):
        pose = pose_of(speaker, vertices, (0.0, pitch, yaw), place)
        seen = sighting_of(speaker, vertices, texture, pose, camera, renderer)
        if seen is not None:
            yield seen


def pose_of(
    speaker: Speaker, vertices: FloatArray, angles: tuple[float, float, float], place: FloatArray
) -> Pose:
    """A head turned by roll, pitch and yaw, radians, its face at a place (3,), camera frame, mm."""
    roll, pitch, yaw = angles
    turns = rotations(np.array([[0, 0, roll], [pitch, 0, 0], [0, yaw, 0]], np.float64))
    middle = vertices[speaker.landmarks["eye_corners"]].mean(axis=0) - [0.0, 20.0, 30.0]
    rotation = turns[0] @ turns[1] @ turns[2] @ FACING
    return Pose(rotation, place - rotation @ middle)


def sighting_of(
    speaker: Speaker,
    vertices: FloatArray,
    texture: Image,
    pose: Pose,
    camera: Camera,
    renderer: Renderer,
    light: Light = USUAL_LIGHT,
    coarse: float = 1.0,
) -> Sighting | None:
    """Sighting by the network of a head in a drawing; None where it sees no face.

    `coarse` pixels of the drawing are blurred into one.
    """
    none = np.zeros((0, *vertices.shape), np.float32)
    classes = speaker.facet_class.astype(np.int32)
    scene = Scene(vertices.astype(np.float32), none, speaker.faces, speaker.uv, classes, texture)
    picture = lit_picture(scene, pose, camera, renderer, light)
    if coarse > 1:
        small = cv2.resize(
            picture, None, fx=1 / coarse, fy=1 / coarse, interpolation=cv2.INTER_AREA
        )
        picture = np.asarray(cv2.resize(small, picture.shape[1::-1]), np.uint8)
    face = find_face(picture)
    seen = None if face is None else landmarks_of(picture, face)
    return None if seen is None else Sighting(vertices, pose, camera, seen)


def lit_picture(
    scene: Scene, pose: Pose, camera: Camera, renderer: Renderer, light: Light
) -> Image:
    """A picture of a head under a lamp before a grey wall, drawn twice as fine and averaged."""
    window = Window(0, 0, *camera.size, 2.0)
    one = Candidates.one(np.zeros(scene.n_modes), pose)
    buffers = renderer.draw(scene, one, camera, window)[0]
    normals = vertex_normals(scene.mean.astype(np.float64), scene.faces)[scene.faces]
    shown = np.einsum("hwc,hwcd->hwd", buffers.barycentrics, normals[buffers.facet_id - 1])
    falling = shown @ pose.rotation.T @ (light.lamp / np.linalg.norm(light.lamp))
    shade = light.ambient + light.diffuse * np.clip(falling, 0, None)
    fine = np.where(buffers.covered[..., None], buffers.rgb * shade[..., None], light.wall)
    small = cv2.resize(fine * light.tint, camera.size, interpolation=cv2.INTER_AREA)
    return np.asarray(np.rint(np.clip(small, 0, 255)), np.uint8)
