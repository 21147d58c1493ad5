"""A first pose of the head: by a face that was found, or by a box around the mouth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import FACING, Pose, rotations
from abs_engine.face.head import MouthModel
from abs_engine.tracking.detection.face_detection import Face
from abs_engine.tracking.settings.detection import DETECTION

MOUTH = 3  # of the points that tell the pose: eyes, tip of the nose, mouth
_MARK_DEVIATION = np.array(DETECTION.mark_deviation)
_TURN_DEVIATION = np.array(DETECTION.turn_deviation)


@dataclass(frozen=True)
class FaceBox:
    """A square around a face: left, top and side length, pixels."""

    x: float
    y: float
    size: float

    @property
    def mouth(self) -> tuple[float, float]:
        """Expected centre of the mouth, pixels."""
        return self.x + 0.5 * self.size, self.y + DETECTION.mouth_height * self.size

    @property
    def centre(self) -> FloatArray:
        """Its middle (2,), pixels."""
        return np.array([self.x, self.y]) + 0.5 * self.size

    @classmethod
    def around_mouth(cls, x: float, y: float, width: float, height: float) -> FaceBox:
        """The face box that a mouth box (left, top, width, height) belongs to."""
        size = width / DETECTION.mouth_width
        return cls(x + width / 2 - size / 2, y + height / 2 - DETECTION.mouth_height * size, size)

    @classmethod
    def around_lips(cls, pixels: FloatArray) -> FaceBox:
        """The face box that lips at some pixels (N, 2) belong to."""
        low, size = pixels.min(axis=0), np.ptp(pixels, axis=0)
        return cls.around_mouth(*low.tolist(), *size.tolist())

    def shown(self, faces: Sequence[Face]) -> Face | None:
        """The face whose mouth is where this box expects it; None if there is none."""
        away = [np.abs(face.mouth - self.mouth).max() for face in faces]
        near = [k for k, far in enumerate(away) if far < 0.5 * DETECTION.mouth_width * self.size]
        return faces[min(near, key=away.__getitem__)] if near else None

    def nearest(self, faces: Sequence[Face]) -> Face | None:
        """The face whose mouth is nearest to where this box expects it; None if all are far.

        Far is farther than the face is large, as another person's is.
        """
        away = [(np.abs(face.mouth - self.mouth).max() / face.size, face) for face in faces]
        far, face = min(away, key=lambda one: one[0], default=(np.inf, None))
        return face if far < 1 else None


def first_pose(box: FaceBox, camera: Camera, mouth: FloatArray) -> Pose:
    """An upright head that faces the camera, its `mouth` (3,), mm, where the box expects it."""
    depth = camera.matrix[0, 0] * DETECTION.box_width / box.size
    ahead = Pose(FACING, np.array([0.0, 0.0, depth]) - FACING @ mouth)
    return with_mouth_at(ahead, np.array(box.mouth), camera, mouth)


def face_marks(model: MouthModel) -> FloatArray:
    """Points at which the detector would see eyes, tip of the nose and mouth of a head, (4, 3) mm.

    Those of a person who is not known are somewhat farther apart than the average head's.
    """
    at, marks = model.head.mean.astype(np.float64), model.speaker.landmarks
    right, left = np.split(at[marks["eye_corners"]], 2)
    nose = at[marks["nose_tip"]].mean(axis=0)
    lips = at[marks["inner_lip_8"][[2, 6]]].mean(axis=0)
    seen = np.stack([right.mean(axis=0), left.mean(axis=0), nose, lips]) + DETECTION.seen_at
    if not model.known:
        seen[:2, 0] *= DETECTION.eyes_apart / np.ptp(seen[:2, 0])
    return np.asarray(seen)


def pose_of_face(face: Face, camera: Camera, marks: FloatArray) -> Pose:
    """The head's pose by a face that was found; its mouth is just where it was seen.

    The most probable one, as people, heads' poses and the detector vary: size and roll come from
    the eyes, yaw from the tip of the nose; of pitch little can be told. `marks` (4, 3), mm, are the
    head's, see `face_marks`.
    """
    from scipy.optimize import least_squares  # not for every clip: it takes a while to import

    seen = camera.undistort(face.points[: len(marks)])
    middle = marks.mean(axis=0)
    eyes, width = seen[1] - seen[0], np.linalg.norm(marks[1] - marks[0])
    depth = width / np.linalg.norm(eyes)
    roll = np.array([[0.0, 0.0, np.arctan2(eyes[1], eyes[0])]])
    leaning = rotations(roll)[0]

    def posed(x: FloatArray) -> Pose:
        rotation = leaning @ rotations(x[None, :3])[0] @ FACING
        centre = np.array([*(x[3:5] * depth), depth * np.exp(x[5])])
        return Pose(rotation, centre - rotation @ middle)

    def misfit(x: FloatArray) -> FloatArray:
        at = posed(x).apply(marks)
        away = (at[:, :2] / at[:, 2:] - seen) @ leaning[:2, :2] * depth / _MARK_DEVIATION
        return np.concatenate([away.ravel(), x[:3] / _TURN_DEVIATION])

    start = np.r_[np.zeros(3), seen.mean(axis=0), 0.0]
    found = posed(least_squares(misfit, start).x)
    return _moved_to(found, marks[MOUTH], seen[MOUTH])


def with_mouth_at(
    pose: Pose, pixel: NDArray[np.floating], camera: Camera, mouth: FloatArray
) -> Pose:
    """The pose moved across the line of sight until a `mouth` (3,), mm, is seen at a pixel (2,)."""
    return _moved_to(pose, mouth, camera.undistort(np.asarray(pixel, np.float64)))


def _moved_to(pose: Pose, point: FloatArray, ray: FloatArray) -> Pose:
    """The pose moved across the line of sight until a point (3,) lies on a ray (2,) at depth 1."""
    at = pose.apply(point)
    return Pose(pose.rotation, pose.translation + np.array([*(ray * at[2]), at[2]]) - at)
