"""Appearance of a face that was made of measured points, learned from pictures of its visemes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.capture.viseme_pictures import VisemePicture
from abs_engine.core.camera import Camera
from abs_engine.core.errors import PictureError
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Renderer
from abs_engine.face.appearance.visibility import Sighting
from abs_engine.face.talking import TalkingFace
from abs_engine.face.talking_file import save_talking
from abs_engine.io.pictures import read_image
from abs_engine.learn.articulatory import Build
from abs_engine.learn.measured.face import MeasuredFace
from abs_engine.learn.talking import learn_face
from abs_engine.learn.training import checksum
from abs_engine.tracking.heads import correspondence_of
from abs_engine.tracking.landmark_correspondence import Correspondence
from abs_engine.tracking.viseme_poses import by_texture, check_pose, pose_by_landmarks


@dataclass(frozen=True, eq=False)
class WrittenFace:
    """A face that was made of measured points, as it is written.

    Parameters
    ----------
    made : MeasuredFace
    looks : TalkingFace or None
        The same with its appearance.
    """

    made: MeasuredFace
    looks: TalkingFace | None

    def write(self, path: Path) -> list[str]:
        """Write the file of a talking face, and return what is to be said of it.

        Raises
        ------
        OutputError
            If it exists or cannot be written.
        ParameterError
            If its name is none that can be printed.
        """
        head, smooth = self.made.head, self.made.smooth
        face = self.looks or self.made.shape
        save_talking(path, face, path.stem, checksum(head.speaker), self.made.neutral)
        share = (
            f"a smooth field adds what it predicts of that at points left out, "
            f"{smooth.explained:.0%} of its variance"
        )
        looks = "no appearance but colours" if self.looks is None else "with appearance"
        return [
            f"face: a head and its face units leave {head.misfit:.2f} mm (RMS) of the points; "
            + share,
            f"wrote {path}, {looks}",
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
