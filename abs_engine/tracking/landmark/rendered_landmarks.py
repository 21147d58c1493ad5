"""Places of landmarks on a head that nobody marked: by drawing it and looking."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import FaceNotFoundError
from abs_engine.core.geometry import FACING, Pose, rotations, vertex_normals
from abs_engine.core.scene import Candidates, Renderer, Scene
from abs_engine.face.head import mouth_facets
from abs_engine.face.rings import rings_of
from abs_engine.io.assets import LIPS_OF_68, Speaker, load_speaker
from abs_engine.tracking.detection.face_detection import find_face
from abs_engine.tracking.detection.landmarks import landmarks_of
from abs_engine.tracking.landmark.landmark_correspondence import (
    Correspondence,
    Sighting,
    learn_correspondence,
    load_correspondence,
)
from abs_engine.tracking.settings.landmarks import LANDMARK_EVIDENCE

OF_68 = np.array([
    162, 234, 93, 58, 172, 136, 149, 148, 152, 377, 378, 365, 397, 288, 323, 454, 389, 71, 63, 105,
    66, 107, 336, 296, 334, 293, 301, 168, 197, 5, 4, 75, 97, 2, 326, 305, 33, 160, 158, 133, 153,
    144, 362, 385, 387, 263, 373, 380, 61, 39, 37, 0, 267, 269, 291, 405, 314, 17, 84, 181, 78, 82,
    13, 312, 308, 317, 14, 87,
])  # fmt: skip
"""The network's points that lie where the usual 68 do."""


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


def correspondence_of(speaker: Speaker, renderer: Renderer) -> Correspondence:
    """Places of the landmarks on a speaker's head: beside its file, or by drawing it and looking.

    Raises
    ------
    FaceNotFoundError
        If the network sees no face in the drawings.
    """
    beside = load_correspondence(speaker)
    if beside is not None:
        return beside
    texture = speaker.texture()
    vertices = speaker.vertices.astype(np.float64)
    found = learn_correspondence(speaker, list(sightings_of(speaker, vertices, texture, renderer)))
    usual = load_correspondence(load_speaker())
    noise = found.noise if usual is None else replace(usual.noise, bias=found.noise.bias)
    deviation = np.maximum(found.deviation, LANDMARK_EVIDENCE.usual_deviation)
    return replace(found, deviation=deviation, noise=noise)


def with_network(head: Speaker, renderer: Renderer) -> Speaker:
    """The head with the network's points, and with all 68 landmarks where they were not given.

    Raises
    ------
    ModelFormatError
        If its landmarks are not on its mouth, as `build_mouth_model` asks.
    FaceNotFoundError
        If the network sees no face in drawings of it.
    """
    rings_of(head, np.unique(head.faces[mouth_facets(head, head.vertices)]))
    try:
        found = correspondence_of(head, renderer)
    except FaceNotFoundError as error:
        raise FaceNotFoundError(
            error.problem,
            "check that its faces point outwards and its landmarks lie where they should, or give "
            "it a texture",
        ) from error
    points = {"landmark_68": _landmark_68(head, found), **head.points}
    return replace(head, points=points, network=found.arrays())


def _landmark_68(head: Speaker, found: Correspondence) -> NDArray[np.int32]:
    """The vertices nearest to the network's points; those of the lips are known better."""
    own = np.asarray(found.corners[OF_68, found.weights[OF_68].argmax(axis=1)], np.int32)
    marks = head.landmarks
    own[LIPS_OF_68] = np.r_[marks["outer_lip_20"], marks["inner_lip_8"]]
    own[30], own[8] = marks["nose_tip"][0], marks["chin"][0]
    own[[36, 39, 42, 45]] = marks["eye_corners"]
    return own
