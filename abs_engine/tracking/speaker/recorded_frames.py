"""Frames of recordings with the landmarks of their face; their colours and camera are checked."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import FloatArray, Image, evenly
from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.face.appearance.colourless import in_colour
from abs_engine.face.appearance.exposure import Exposure, colourless
from abs_engine.io.video import read_frames
from abs_engine.tracking.detection.face_choice import FaceChoice, FaceFollower
from abs_engine.tracking.detection.landmarks import Landmarks
from abs_engine.tracking.option_checks import check_camera
from abs_engine.tracking.person.frame_choice import turned_apart
from abs_engine.tracking.runs.record import camera_of
from abs_engine.tracking.runs.recordings import Recording
from abs_engine.tracking.settings.preparation import PREPARATION


def sighted(recording: Recording, frames: Sequence[int]) -> Iterator[tuple[int, Image, Landmarks]]:
    """Frames of a recording with their numbers and its face's landmarks, where they are seen."""
    follower, wanted = FaceFollower(recording.choice), set(map(int, frames))
    last = max(wanted, default=-1)
    for index, image in enumerate(islice(read_frames(recording.video), last + 1)):
        seen = follower.step(image)
        if index in wanted and seen is not None:
            yield index, image, seen


def pictures(recording: Recording, frames: Sequence[int]) -> list[tuple[Image, Landmarks]]:
    """Frames of a recording with the landmarks of its face, where they are seen."""
    return [(image, marks) for _, image, marks in sighted(recording, frames)]


def turned(recording: Recording, count: int) -> list[tuple[Image, Landmarks]]:
    """So many usable frames of a recording, those in which the head faces most differently."""
    usable = np.flatnonzero(recording.usable)
    looked = evenly(len(usable), PREPARATION.speaker_most)
    seen = pictures(recording, usable[looked].tolist())
    return [seen[k] for k in turned_apart([marks for _, marks in seen], count)] if seen else []


def check_colours(given: Sequence[tuple[Path, Path, FaceChoice]]) -> None:
    """Raise `ParameterError` for a recording without colour among others in colour.

    Each is the path that was given, its video and its face. It is judged by the first frame that
    shows the face, as are clips that are tracked with a learned face. A video that shows none is
    refused later, for that.
    """
    seen = [(path, _first(video, choice)) for path, video, choice in given]
    faces = [(path, one) for path, one in seen if one is not None]
    if not in_colour([one for _, one in faces]):
        return
    for path, one in faces:
        if not in_colour([one]):
            raise ParameterError(
                f"{colourless(path, Exposure.of([one]))}, but other recordings have",
                "leave it out, or give recordings that are all without colour",
            )


def _first(video: Path, choice: FaceChoice) -> tuple[Image, FloatArray] | None:
    """The first frame of a video that shows a face, with its landmarks' pixels; None without."""
    follower = FaceFollower(choice)
    for image in islice(read_frames(video), PREPARATION.look_at):
        marks = follower.step(image)
        if marks is not None:
            return image, marks.pixels
    return None


def camera_used(
    recordings: Iterable[Recording], given: Camera | None, size: tuple[int, int]
) -> Camera:
    """The given camera, or the ideal one of videos of a size (width, height).

    Raises
    ------
    ParameterError
        If the given one is of another picture size, or a recording was tracked with another camera.
    """
    check_camera(given, size)
    camera = given or Camera.ideal(size)
    for one in recordings:
        own = camera_of(one.run)
        if not (
            np.allclose(own.matrix, camera.matrix)
            and np.allclose(own.distortion, camera.distortion)
        ):
            raise ParameterError(
                f"{one.path} was tracked with another camera than is used here",
                "give the camera that it was tracked with, or its video in place of the run",
            )
    return camera
