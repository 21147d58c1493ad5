"""The search for the mouth before anything is known of the person: by faces, then by colour."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import PoseFrame
from abs_engine.face.head import MouthModel
from abs_engine.tracking.detection.face_detection import find_face
from abs_engine.tracking.detection.initial_pose import face_marks, pose_of_face
from abs_engine.tracking.settings.preparation import PREPARATION


@dataclass(frozen=True, eq=False)
class CalibrationFrame:
    """A frame that the person is fitted on.

    Parameters
    ----------
    image : (H, W, 3) uint8 RGB
    pose : Pose
        The head's pose by its rigid motion from the reference frame.
    """

    image: Image
    pose: Pose


def shifted(pose: Pose, shift: FloatArray, pivot: FloatArray) -> Pose:
    """A pose after a step (6,) of it: radians about the camera's axes, and mm of the pivot."""
    return PoseFrame(pose, pivot).pose(shift)


def moved(
    frames: Sequence[CalibrationFrame], shift: FloatArray, pivot: FloatArray
) -> list[CalibrationFrame]:
    """The frames with the constant correction `shift` (6,) of their poses."""
    return [replace(f, pose=shifted(f.pose, shift, pivot)) for f in frames]


def shift_of_faces(
    model: MouthModel, frames: Sequence[CalibrationFrame], camera: Camera
) -> FloatArray | None:
    """Places of several frames' faces, less where the first one's was followed to.

    It is a constant correction (6,) of the poses, radians and mm; None where fewer than half of the
    frames show the face. The median of several wanders less than one. Other faces, far from where
    the head was followed to, do not count.
    """
    marks, shifts = face_marks(model), []
    for frame in frames:
        face = find_face(frame.image)
        if face is None:
            continue
        pose, mouth = pose_of_face(face, camera, marks), frame.pose.apply(model.pivot)
        move = pose.apply(model.pivot) - mouth
        near = np.abs(move[:2]).max() < PREPARATION.elsewhere
        if near and abs(move[2]) < PREPARATION.elsewhere_depth * mouth[2]:
            turn = Pose(pose.rotation @ frame.pose.rotation.T, np.zeros(3)).rotation_vector
            shifts.append(np.concatenate([turn, move]))
    return np.median(shifts, axis=0) if 2 * len(shifts) >= len(frames) else None
