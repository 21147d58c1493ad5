"""Poses that were measured elsewhere, laid on a head that was fitted to landmarks.

Whose head they are of is not known: its size, its axes and its origin may be others. The size
follows from how far apart the eyes are seen at the poses' distance; axes and origin differ by a
constant, which the frames that the head was fitted to tell.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.tracking.external_poses import GivenFollower, GivenMotion
from abs_engine.tracking.face_choice import FaceFollower
from abs_engine.tracking.frame_state import HeadFrame, Memory, SeenFace
from abs_engine.tracking.landmark_fit import FrameLandmarks, HeldPose, fit_frame
from abs_engine.tracking.landmark_motion import LandmarkMotion
from abs_engine.tracking.landmark_rays import SeenRays
from abs_engine.tracking.landmark_shape import LandmarkShape
from abs_engine.tracking.landmarks import EYES, Landmarks
from abs_engine.tracking.settings.head import HEAD_POSE
from abs_engine.tracking.settings.preparation import PREPARATION

_EXACT = np.diag(9 / np.square(PREPARATION.pose_deviation))  # three times what a frame leaves open


@dataclass(frozen=True, eq=False)
class PosedMotion:
    """Given poses of a fitted head, whose landmarks are looked for beside them.

    Parameters
    ----------
    own : LandmarkMotion
        By which it would be followed without them.
    given : GivenMotion
        Its poses, as `aligned` gives them.
    """

    own: LandmarkMotion
    given: GivenMotion

    @property
    def alone(self) -> bool:
        """Whether it may be followed in a thread of its own, ahead of the fits."""
        return self.own.alone

    def follower(self) -> PosedFollower:
        """Follower of the head from the first frame on."""
        return PosedFollower(self)


class PosedFollower:
    """Takes each frame's pose as it is given, and the posture that landmarks show in it."""

    def __init__(self, motion: PosedMotion) -> None:
        self._own, self._given = motion.own, GivenFollower(motion.given.given)
        self._faces = FaceFollower(motion.own.choice, motion.own.known)
        self._last: FrameLandmarks | None = None

    def step(self, image: Image, _memory: Memory | None = None) -> HeadFrame:
        """The next frame; without landmarks where no face is seen, or not in that pose."""
        pose, seen = self._given.step(image).pose, self._faces.step(image)
        cut, last = self._faces.cut, None if self._faces.cut else self._last
        self._last = None if pose is None or seen is None else self._fit(seen, pose, last)
        if seen is None or self._last is None:
            return HeadFrame(image, pose, cut=cut)
        light = self._own.light
        lit = None if light is None else light.balanced(image, seen)
        return HeadFrame(image, pose, SeenFace(seen, self._last), balanced=lit, cut=cut)

    def _fit(
        self, seen: Landmarks, pose: Pose, last: FrameLandmarks | None
    ) -> FrameLandmarks | None:
        own = self._own
        found = fit_frame(own.shape, seen, own.textured.camera, last, HeldPose(pose, _EXACT))
        return found if found.sound(own.shape) else None

    def finish(self) -> None:
        """Say that there are no more frames; `ParameterError` if there are fewer than poses."""
        self._given.finish()


def pupils_by(
    posed: Iterable[tuple[Pose, Landmarks]], shape: LandmarkShape, pupils: float, camera: Camera
) -> float:
    """Distance of a person's pupils, mm, by how far apart the eyes are seen where poses put them.

    Parameters
    ----------
    posed : iterable of (Pose, Landmarks)
    shape : LandmarkShape
        Of the average head, whose `pupils` are so far apart, mm.
    pupils : float
    camera : Camera
    """
    right, left = (shape.mean[pair].mean(axis=0) for pair in EYES)
    apart, middle, seen = left - right, 0.5 * (left + right), []
    for pose, marks in posed:
        rays = SeenRays.of(marks, camera).rays
        one, other = (rays[pair].mean(axis=0) for pair in EYES)
        depth, along = float(pose.apply(middle)[2]), pose.rotation @ apart
        drawn = (along[:2] - 0.5 * (one + other) * along[2]) / depth
        wide = float(np.linalg.norm(drawn))
        seen.append(float(np.linalg.norm(other - one)) / max(wide, 1e-9))
    return pupils * float(np.median(seen))


def aligned(
    given: Sequence[Pose | None], own: Sequence[tuple[int, Pose]], pivot: FloatArray
) -> tuple[Pose | None, ...]:
    """Given poses as poses of the fitted head.

    Parameters
    ----------
    given : sequence of (Pose or None)
        In each frame, in other axes and from another origin.
    own : sequence of (int, Pose)
        Frames that have both, and the fitted head's pose there.
    pivot : (3,) float64, mm, the fitted head's frame
        Between the lips, where both are laid on each other.

    Raises
    ------
    ParameterError
        If they do not turn as the face does.
    """
    pairs = [(pose, one) for k, one in own if (pose := given[k]) is not None]
    turns = Rotation.from_matrix([one.rotation.T @ other.rotation for one, other in pairs])
    turn = turns.mean()
    off = float(np.rad2deg(np.median((turn.inv() * turns).magnitude())))
    if off > HEAD_POSE.given_apart:
        raise ParameterError(
            f"the given poses do not turn as the face does: in half of the frames looked at they "
            f"are {off:.0f} degrees off",
            "check that they are of this video, and turn from the head's axes to the camera's",
        )
    shift = np.median(
        [one.rotation.T @ (o.apply(pivot) - one.apply(pivot)) for one, o in pairs], axis=0
    )
    matrix = turn.as_matrix()
    return tuple(None if one is None else _laid(one, matrix, shift, pivot) for one in given)


def _laid(pose: Pose, turn: FloatArray, shift: FloatArray, pivot: FloatArray) -> Pose:
    """A pose as that of a head that is turned and shifted in its axes."""
    rotation = pose.rotation @ turn
    return Pose(rotation, pose.apply(pivot + shift) - rotation @ pivot)
