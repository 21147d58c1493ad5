"""Drawings of a head from several sides, as the landmark network sees them."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.assets import Speaker
from abs_engine.camera import Camera, Window
from abs_engine.geometry import FACING, Pose, rotations, vertex_normals
from abs_engine.scene import Candidates, Renderer, Scene
from abs_engine.track.correspondence import Sighting
from abs_engine.track.detect import find_face
from abs_engine.track.landmarks import landmarks_of

FloatArray = NDArray[np.float64]
Image = NDArray[np.uint8]

PITCHES, YAWS = (-0.15, 0.1), (-0.6, -0.3, 0.0, 0.3, 0.6)  # radians
_SIDE, _DEPTH = 400, 700.0  # pixels of a drawing, mm from the camera
_LAMP = np.array([0.3, -0.5, -1.0])  # direction to it, camera frame
_AMBIENT, _DIFFUSE, _WALL = 0.45, 0.65, 110  # light of the room, of the lamp; grey of the wall


def sightings_of(
    speaker: Speaker, vertices: FloatArray, texture: Image, renderer: Renderer
) -> Iterator[Sighting]:
    """What the network sees of a head from several sides; sides on which it sees none are left out.

    Parameters
    ----------
    speaker : Speaker
    vertices : (V, 3) float64, mm, head frame
    texture : (H, W, 3) uint8 RGB
    renderer : Renderer
    """
    camera = Camera.ideal((_SIDE, _SIDE))
    none = np.zeros((0, *vertices.shape), np.float32)
    classes = speaker.facet_class.astype(np.int32)
    scene = Scene(vertices.astype(np.float32), none, speaker.faces, speaker.uv, classes, texture)
    middle = vertices[speaker.landmarks["eye_corners"]].mean(axis=0) - [0.0, 20.0, 30.0]
    for pitch, yaw in product(PITCHES, YAWS):
        turn = rotations(np.array([[pitch, 0, 0], [0, yaw, 0]], np.float64))
        rotation = turn[0] @ turn[1] @ FACING
        pose = Pose(rotation, np.array([0.0, 0.0, _DEPTH]) - rotation @ middle)
        picture = _lit(scene, pose, camera, renderer)
        face = find_face(picture)
        seen = None if face is None else landmarks_of(picture, face)
        if seen is not None:
            yield Sighting(vertices, pose, camera, seen)


def _lit(scene: Scene, pose: Pose, camera: Camera, renderer: Renderer) -> Image:
    """A picture of a head under a lamp before a grey wall, drawn twice as fine and averaged."""
    window = Window(0, 0, *camera.size, 2.0)
    one = Candidates.one(np.zeros(scene.n_modes), pose)
    buffers = renderer.draw(scene, one, camera, window)[0]
    normals = vertex_normals(scene.mean.astype(np.float64), scene.faces)[scene.faces]
    shown = np.einsum("hwc,hwcd->hwd", buffers.barycentrics, normals[buffers.facet_id - 1])
    light = shown @ pose.rotation.T @ (_LAMP / np.linalg.norm(_LAMP))
    lit = buffers.rgb * (_AMBIENT + _DIFFUSE * np.clip(light, 0, None))[..., None]
    fine = np.where(buffers.covered[..., None], lit, _WALL)
    small = cv2.resize(fine, camera.size, interpolation=cv2.INTER_AREA)
    return np.asarray(np.rint(np.clip(small, 0, 255)), np.uint8)
