"""Poses that were measured elsewhere, laid on a head that was fitted to landmarks.

Whose head they are of is not known: its unit of length, axes and origin may differ. All three
follow from frames in which the fitted head is found by its landmarks and texture, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.errors import FaceNotFoundError, ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.tracking.external_poses import GivenFollower, GivenMotion
from abs_engine.tracking.face_choice import FaceFollower
from abs_engine.tracking.frame_state import HeadFrame, Memory, SeenFace
from abs_engine.tracking.landmark_fit import FrameLandmarks, HeldPose, fit_frame
from abs_engine.tracking.landmark_motion import LandmarkMotion
from abs_engine.tracking.landmarks import Landmarks
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
        Between the lips, where both are aligned.

    Raises
    ------
    ParameterError
        If they do not move as the face does.
    FaceNotFoundError
        If no frame has both.
    """
    pairs = [(pose, one) for k, one in own if (pose := given[k]) is not None]
    if not pairs:
        raise FaceNotFoundError("no frame has a pose and a face", "give poses of this video")
    turns = Rotation.from_matrix([one.rotation.T @ other.rotation for one, other in pairs])
    turn = turns.mean()
    off = float(np.rad2deg(np.median((turn.inv() * turns).magnitude())))
    scale, shift, away = _placed(pairs, turn.apply(pivot), pivot)
    if off > HEAD_POSE.given_apart or away > HEAD_POSE.given_away:
        raise ParameterError(
            f"the given poses do not move as the face does: in half of the frames looked at they "
            f"are {off:.0f} degrees and {away:.0f} mm or more off",
            "check that they are of this video, and map the head's axes to the camera's",
        )
    matrix = turn.as_matrix()
    return tuple(None if one is None else _laid(one, matrix, scale, shift, pivot) for one in given)


def _placed(
    pairs: Sequence[tuple[Pose, Pose]], usual: FloatArray, pivot: FloatArray
) -> tuple[float, FloatArray, float]:
    """Scale of given poses, the pivot in their axes (3,), mm, and how far off the median frame is.

    In a head that hardly moves, where the pivot `usual`ly is, in the same axes, separates scale and
    depth.
    """
    turns = np.stack([one.rotation for one, _ in pairs])
    there = np.stack([one.translation for one, _ in pairs])
    wanted = np.stack([other.apply(pivot) for _, other in pairs])

    def off(x: FloatArray) -> FloatArray:
        return np.asarray(x[0] * there + turns @ x[1:] - wanted)

    def residuals(x: FloatArray) -> FloatArray:
        held = (x[1:] - usual) / HEAD_POSE.given_origin
        return np.concatenate([off(x).ravel() / PREPARATION.pose_deviation[3], held])

    ratio = float(np.median(wanted[:, 2] / (there + turns @ usual)[:, 2]))
    found = least_squares(residuals, np.r_[ratio, usual], loss="soft_l1", x_scale=[0.1, 10, 10, 10])
    away = float(np.median(np.linalg.norm(off(found.x), axis=1)))
    return float(found.x[0]), found.x[1:], away


def _laid(pose: Pose, turn: FloatArray, scale: float, shift: FloatArray, pivot: FloatArray) -> Pose:
    """A pose as that of a head with turned axes, the pivot at `shift` in those of the given one."""
    rotation = pose.rotation @ turn
    there = scale * pose.translation + pose.rotation @ shift
    return Pose(rotation, there - rotation @ pivot)
