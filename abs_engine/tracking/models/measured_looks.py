"""A measured face in pictures of its visemes: its poses there, and the appearance they show."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.capture.viseme_pictures import VisemePicture
from abs_engine.core.arrays import FloatArray
from abs_engine.core.blocks import POSE
from abs_engine.core.camera import Camera
from abs_engine.core.errors import FaceNotFoundError, ParameterError, PictureError
from abs_engine.core.geometry import Pose, vertex_normals
from abs_engine.core.pose import at_base, no_correction
from abs_engine.core.scene import Renderer
from abs_engine.core.settings import GENERAL
from abs_engine.face.appearance.visibility import Sighting
from abs_engine.face.talking import TalkingFace
from abs_engine.face.talking_file import save_talking
from abs_engine.fit.settings import TALKING_FIT
from abs_engine.fit.talking import talking_problem
from abs_engine.io.assets import Speaker
from abs_engine.io.pictures import read_image
from abs_engine.learn.articulatory import Build
from abs_engine.learn.measured.face import MeasuredFace
from abs_engine.learn.talking import learn_face
from abs_engine.learn.training import checksum
from abs_engine.optimise.by_nlopt import Simplex
from abs_engine.tracking.detection.face_detection import find_faces
from abs_engine.tracking.detection.landmarks import landmarks_of
from abs_engine.tracking.landmark.landmark_correspondence import Correspondence
from abs_engine.tracking.landmark.landmark_fit import sound_fit
from abs_engine.tracking.landmark.landmark_shape import LandmarkShape
from abs_engine.tracking.landmark.rendered_landmarks import correspondence_of

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


def write_face(path: Path, made: MeasuredFace, looks: TalkingFace | None) -> list[str]:
    """Write the file of a talking face, and return what is to be said of it.

    It was made of measured points; `looks` is the same with its appearance, where that was learned.

    Raises
    ------
    OutputError
        If it exists or cannot be written.
    ParameterError
        If its name is none that can be printed.
    """
    save_talking(path, looks or made.shape, path.stem, checksum(made.head.speaker), made.neutral)
    return [
        f"face: a head and its face units leave {made.head.misfit:.2f} mm (RMS) of the points; a "
        "smooth field adds what it predicts of that at points left out, "
        f"{made.smooth.explained:.0%} of its variance",
        f"wrote {path}, {'no appearance but colours' if looks is None else 'with appearance'}",
    ]


def with_looks(
    made: MeasuredFace,
    built: Build,
    table: Sequence[VisemePicture],
    camera: Camera | None,
    renderer: Renderer,
    tell: Callable[[str], None],
) -> TalkingFace:
    """Learn textures and local appearance of a face from pictures of its corpus' visemes.

    Poses that the table lacks are estimated: by landmarks, then once by the texture that was
    learned with these. The camera is by default an ideal one for pictures of their size. `tell` is
    called with what is begun, in a few words.

    Raises
    ------
    InputFileError
        If a picture cannot be read.
    PictureError
        If pictures differ in size.
    FaceNotFoundError
        If a picture whose pose is to be estimated shows no face.
    ParameterError
        If a picture shows the face elsewhere than the pose that was given has it.
    NothingSeenError
        If the pictures do not show the face.
    """
    pictures = [read_image(picture.path) for picture in table]
    camera = _camera(table, pictures, camera)
    tell("finding the head in the pictures")
    places = correspondence_of(made.head.speaker, renderer)
    seen = [
        _sighting(made, built, picture, image, camera, places)
        for picture, image in zip(table, pictures, strict=True)
    ]
    tell("learning the appearance")
    face = learn_face(made.shape, seen, camera, renderer)
    guessed = [k for k, picture in enumerate(table) if picture.pose is None]
    if not guessed:
        return face
    tell("finding the head by its texture")
    for k in guessed:
        seen[k] = by_texture(face, seen[k], camera, renderer)
    tell("learning the appearance again")
    return learn_face(made.shape, seen, camera, renderer)


def _camera(
    table: Sequence[VisemePicture], pictures: Sequence[NDArray[np.uint8]], camera: Camera | None
) -> Camera:
    """The camera of pictures, all of which must have its size."""
    height, width = pictures[0].shape[:2]
    chosen = camera or Camera.ideal((width, height))
    for picture, image in zip(table, pictures, strict=True):
        if image.shape[1::-1] != chosen.size:
            wide, tall = chosen.size
            raise PictureError(
                f"{picture.path} is {image.shape[1]}x{image.shape[0]}, not {wide}x{tall}",
                "give pictures of one camera, of the size of its calibration",
            )
    return chosen


def _sighting(
    made: MeasuredFace,
    built: Build,
    picture: VisemePicture,
    image: NDArray[np.uint8],
    camera: Camera,
    places: Correspondence,
) -> Sighting:
    """A picture with the head's posture and pose in it."""
    shape, speaker = made.shape, made.head.speaker
    alpha = built.alpha[built.corpus.visemes.index(picture.viseme)]
    vertices = shape.scene.vertices(alpha)
    estimated = partial(pose_by_landmarks, image, vertices, speaker, places, camera, picture.path)
    if picture.pose is None:
        return Sighting(image, vertices, estimated(), alpha)
    own, frame = picture.pose, shape.frame  # of the points
    pose = Pose(own.rotation @ frame.rotation, own.apply(frame.translation[None])[0])
    face = np.asarray(vertices, np.float64)[speaker.points["face"]]
    check_pose(pose, face, camera, picture.path, estimated)
    return Sighting(image, vertices, pose, alpha)
