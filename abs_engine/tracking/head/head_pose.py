"""A known head's pose in a frame: by its texture, its landmarks, and where it faced just before.

Landmarks alone err by 2 to 3 degrees from frame to frame, and by as much for a whole person; the
texture ties each frame to those that the head was fitted on.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Renderer
from abs_engine.core.threads import one_thread
from abs_engine.tracking.detection.landmarks import Landmarks, SeenRays
from abs_engine.tracking.detection.mouth_search import shifted
from abs_engine.tracking.head.match_equations import linearised_at
from abs_engine.tracking.landmark.head_equations import Equations, HeadGuess, landmark_equations
from abs_engine.tracking.landmark.landmark_fit import FrameLandmarks, HeldPose, fit_frame, sound_fit
from abs_engine.tracking.landmark.landmark_noise import LandmarkNoise
from abs_engine.tracking.landmark.landmark_shape import LandmarkShape
from abs_engine.tracking.settings.head import HEAD_POSE
from abs_engine.tracking.texture.head_texture import Gray, HeadBody, HeadView, gray_of, match

_DAMPING = 1e-6
_FLOOR = np.array(HEAD_POSE.pose_floor)


class _Settled(NamedTuple):
    """A pose, the last equations of it, and how far matches were off then.

    That is `MatchEquations.off`; infinite where nothing matched.
    """

    pose: Pose
    system: Equations
    off: float


@dataclass(frozen=True, eq=False)
class TexturedHead:
    """A person's head, and frames that show its texture.

    Parameters
    ----------
    body : HeadBody
        Of the person, with nothing of the identity left to fit.
    shape : LandmarkShape
        The person's landmarks, without a bias.
    noise : LandmarkNoise
        Of the network on this person.
    shift : (6,) float64 or None
        A constant correction of all poses, radians and mm: what the mouth says of them.
    """

    body: HeadBody
    shape: LandmarkShape
    noise: LandmarkNoise
    views: tuple[HeadView, ...]
    camera: Camera
    renderer: Renderer
    shift: FloatArray | None = None

    def pose(
        self,
        gray: Gray,
        landmarks: Landmarks,
        start: FrameLandmarks,
        before: HeldPose | None,
        interval: float,
    ) -> HeldPose:
        """The head's pose in a frame, from where landmarks alone put it.

        `before` is its pose a short `interval`, seconds, ago. It counts where the texture is not
        seen clearly, as in a blur or a blink; elsewhere a tremor would lose by it.
        """
        seen, begun = SeenRays.of(landmarks, self.camera), self._moved_back(start.pose)
        own = self._landmarks(seen, begun, start.posture)
        found = self._settled(gray, begun, start.posture, own)
        if before is not None and found.off > HEAD_POSE.clear:
            held = replace(before, pose=self._moved_back(before.pose))
            near = own.plus(hardly_turned(begun, held, interval, len(start.posture)))
            found = self._settled(gray, begun, start.posture, near, near.step())
        pose = found.pose
        if self.shift is not None:
            pose = shifted(pose, self.shift, self.shape.pivot)
        covariance = np.linalg.inv(found.system.of_pose()) + np.diag(_FLOOR**2)
        return HeldPose(pose, np.asarray(np.linalg.inv(covariance), np.float64))

    def _settled(
        self,
        gray: Gray,
        pose: Pose,
        posture: FloatArray,
        own: Equations,
        moved_by: FloatArray | None = None,
    ) -> _Settled:
        """The pose by `own` equations about a pose and a posture, and by the texture.

        The texture is looked for where a first step `moved_by` (6 + M,) takes them.
        """
        if moved_by is None:
            moved_by = np.zeros(6 + len(posture))
        else:
            pose, posture = shifted(pose, moved_by, self.shape.pivot), posture + moved_by[6:]
        vertices, drawn, off = self.body.vertices(np.zeros(0), posture), posture, np.inf
        nearest = min(self.views, key=lambda v: v.pose.angle_to(pose))
        view = HeadView(gray, pose, vertices, nearest.normals)
        # Once is enough: the texture hardly moves the head, and landmarks cost more than it
        matches = match(self.body, nearest, view, self.camera, self.renderer)
        points = np.zeros((0, 3)) if matches is None else matches.of(vertices)
        for _ in range(HEAD_POSE.frame_steps):
            system = own.after(moved_by)
            if matches is not None:
                moved = np.tensordot(posture - drawn, matches.posture, 1)
                told = linearised_at(
                    self.body, matches, nearest, pose, points + moved, self.camera, who=False
                )
                system, off = system.plus(told.normal), told.off(matches.sigma)
            step = system.step()
            pose, posture = shifted(pose, step, self.shape.pivot), posture + step[6:]
            moved_by = moved_by + step
            if np.abs(step[:3]).max() < HEAD_POSE.frame_settled:
                break
        return _Settled(pose, system, off)

    def _moved_back(self, pose: Pose) -> Pose:
        """A pose before the correction of all poses."""
        return pose if self.shift is None else shifted(pose, -self.shift, self.shape.pivot)

    def _landmarks(self, seen: SeenRays, pose: Pose, posture: FloatArray) -> Equations:
        """Of pose (6) and posture (M) by landmarks, with the posture's prior."""
        guess = HeadGuess(pose, np.zeros(0), np.zeros(0), posture)
        information, gradient = landmark_equations(
            self.shape, self.noise, seen, guess, HEAD_POSE.landmarks_alike
        )
        own = np.r_[_DAMPING * np.diag(information)[:6], np.ones(len(posture))]
        return Equations(information + np.diag(own), gradient + np.r_[np.zeros(6), posture])


def hardly_turned(pose: Pose, before: HeldPose, interval: float, modes: int) -> Equations:
    """Equations of a pose and a posture (M,): heads turn little in an interval, in seconds.

    From where a head faced `before`, as surely as that is known. Farther turns count less (Cauchy),
    as heads now and then do turn fast.
    """
    turn = Pose(pose.rotation @ before.pose.rotation.T, np.zeros(3)).rotation_vector
    spread = np.linalg.inv(before.information)[:3, :3]
    spread = spread + (HEAD_POSE.turn_speed * interval) ** 2 * np.eye(3)
    known = np.linalg.inv(spread)
    known /= 1 + turn @ known @ turn / HEAD_POSE.turn_stray**2
    information, gradient = np.zeros((6 + modes, 6 + modes)), np.zeros(6 + modes)
    information[:3, :3], gradient[:3] = known, known @ turn
    return Equations(information, gradient)


def placed_fit(
    textured: TexturedHead,
    shape: LandmarkShape,
    image: NDArray[np.uint8],
    landmarks: Landmarks,
    last: FrameLandmarks | None = None,
    interval: float = 0.04,
) -> FrameLandmarks | None:
    """Pose of a frame by landmarks and texture; None where the landmarks are no face's.

    `shape` is the person's landmarks as they are known by now, with their bias; `last` is the frame
    before, an `interval`, in seconds, ago.
    """
    first = sound_fit(shape, landmarks, textured.camera, last, HEAD_POSE.start_settled)
    if first is None:
        return None
    with one_thread():
        before = None if last is None else last.held
        held = textured.pose(gray_of(image), landmarks, first, before, interval)
    found = fit_frame(shape, landmarks, textured.camera, first, held)
    return found if found.sound(shape) else first
