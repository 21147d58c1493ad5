"""Poses of a known head in pictures of its visemes: by landmarks, then by its own texture."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.blocks import POSE
from abs_engine.core.camera import Camera
from abs_engine.core.errors import FaceNotFoundError, ParameterError
from abs_engine.core.geometry import Pose, vertex_normals
from abs_engine.core.pose import at_base, no_correction
from abs_engine.core.scene import Renderer
from abs_engine.core.settings import GENERAL
from abs_engine.face.appearance.visibility import Sighting
from abs_engine.face.talking import TalkingFace
from abs_engine.fit.settings import TALKING_FIT
from abs_engine.fit.talking import talking_problem
from abs_engine.io.assets import Speaker
from abs_engine.optimise.by_nlopt import Simplex
from abs_engine.tracking.face_detection import find_faces
from abs_engine.tracking.landmark_correspondence import Correspondence
from abs_engine.tracking.landmark_fit import sound_fit
from abs_engine.tracking.landmark_shape import LandmarkShape
from abs_engine.tracking.landmarks import landmarks_of

_AWAY = 20.0
"""mm RMS, across the line of sight, that a pose may lie from where landmarks have the face. Chosen:
right ones lie up to 5 away."""
_POSE = (
    "give the pose of the points' frame in the camera's axes, x right, y down, z forward, in "
    "radians and mm, and the camera; or leave its cells empty"
)


def pose_by_landmarks(
    image: NDArray[np.uint8],
    vertices: NDArray[np.floating],
    speaker: Speaker,
    correspondence: Correspondence,
    camera: Camera,
    path: Path,
) -> Pose:
    """Pose of a head (V, 3), mm, with the speaker's mesh, that keeps its posture in a picture.

    The path is the picture's, for what is said of it.

    Raises
    ------
    FaceNotFoundError
        If the picture shows no face.
    """
    still = np.asarray(vertices, np.float64)
    none = np.zeros((0, *still.shape))
    shape = LandmarkShape.of(
        correspondence, still, vertex_normals(still, speaker.faces), none, none,
        still[speaker.lip_ring].mean(axis=0),
    )  # fmt: skip
    for face in find_faces(image):
        seen = landmarks_of(image, face)
        found = None if seen is None else sound_fit(shape, seen, camera, None)
        if found is not None:
            return found.pose
    raise FaceNotFoundError(
        f"no face is found in {path}", "give its pose in the table, or leave the picture out"
    )


def check_pose(
    pose: Pose, face: FloatArray, camera: Camera, path: Path, estimated: Callable[[], Pose]
) -> None:
    """Refuse a pose that was given of a face (V, 3), mm, where a picture shows the face elsewhere.

    A picture of which no pose can be `estimated`, as no face is found, only has to have it in view.

    Raises
    ------
    ParameterError
        If the face lies outside of the picture, or far from where landmarks have it.
    """
    there, size = pose.apply(face), np.array(camera.size)
    ahead = there[:, 2] >= GENERAL.nearest
    at = camera.project(there[ahead])
    if 2 * ((at >= 0) & (at < size)).all(axis=1).sum() < len(face):
        raise ParameterError(f"by its pose, the face is not in {path}", _POSE)
    try:
        seen = estimated().apply(face)
    except FaceNotFoundError:
        return
    focal = camera.matrix[[0, 1], [0, 1]]
    off = (camera.project(there) - camera.project(seen)) * seen[:, 2].mean() / focal
    away = float(np.sqrt((off**2).sum(axis=1).mean()))
    if away > _AWAY:
        raise ParameterError(
            f"by its pose, the face lies {away:.0f} mm from where {path} shows it", _POSE
        )


def by_texture(face: TalkingFace, seen: Sighting, camera: Camera, renderer: Renderer) -> Sighting:
    """The sighting with the pose that lays its picture best on the texture, its posture held."""
    asked = talking_problem(
        face, "tex_lin", seen.image, camera, seen.pose, seen.parameters, renderer
    )
    placed = replace(asked, free=(POSE,), held=at_base(seen.parameters))
    solver = Simplex(TALKING_FIT.tolerance, TALKING_FIT.placed_limit)
    found = solver.minimise(placed, no_correction(), placed.spec)
    return replace(seen, pose=placed.pose(found.x))
