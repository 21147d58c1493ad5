"""A person's head followed by its landmarks and its texture.

A frame whose texture is not clear leans on the one before; any other stands on its own.

Where its poses are given, they stand in place of the texture.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from abs_engine.core.arrays import Image
from abs_engine.core.geometry import Pose
from abs_engine.core.threads import workers
from abs_engine.face.appearance.colourless import is_grey
from abs_engine.tracking.detection.face_choice import FaceChoice, FaceFollower
from abs_engine.tracking.detection.landmarks import Landmarks
from abs_engine.tracking.detection.light import SkinLight
from abs_engine.tracking.frame.external_poses import GivenMotion
from abs_engine.tracking.frame.frame_state import HeadFrame, Memory, SeenFace
from abs_engine.tracking.head.head_pose import TexturedHead, placed_fit
from abs_engine.tracking.landmark.landmark_fit import FrameLandmarks, HeldPose, fit_frame
from abs_engine.tracking.landmark.landmark_shape import LandmarkShape
from abs_engine.tracking.settings.head import HEAD_POSE


@dataclass(frozen=True, eq=False)
class LandmarkMotion:
    """Stands in for `HeadMotion` where the person's head was fitted to landmarks.

    Parameters
    ----------
    known : tuple of Landmarks or None
        Those of the first frames, which were looked at before.
    light : SkinLight, optional
        The clip's usual light; with it each frame comes in that light, too.
    given : GivenMotion, optional
        The head's poses, which are taken as they are; a frame in which no face is seen, or not in
        its pose, has the pose alone.
    grey_below : float, levels of 255
        Spread of a face's chroma below which a frame has no colour; 0 where none is asked.
    rate : float, frames per second
    """

    shape: LandmarkShape
    textured: TexturedHead
    choice: FaceChoice = field(default_factory=FaceChoice)
    known: tuple[Landmarks | None, ...] = ()
    light: SkinLight | None = None
    given: GivenMotion | None = None
    grey_below: float = 0.0
    rate: float = 25.0

    @property
    def alone(self) -> bool:
        """Whether it may be followed in a thread of its own, ahead of the fits."""
        return workers(self.textured.renderer) > 1

    def follower(self) -> LandmarkFollower:
        """Follower of the head from the first frame on."""
        return LandmarkFollower(self)


class LandmarkFollower:
    """Finds the head in each frame, by its landmarks and its texture, or by given poses."""

    def __init__(self, motion: LandmarkMotion) -> None:
        self._motion, self._faces = motion, FaceFollower(motion.choice, motion.known)
        self._given = None if motion.given is None else motion.given.follower()
        self._last: FrameLandmarks | None = None

    def step(self, image: Image, memory: Memory | None = None) -> HeadFrame:
        """The next frame with the head's pose and posture."""
        motion, seen, cut = self._motion, self._faces.step(image), self._faces.cut
        given = None if self._given is None else self._given.step(image).pose
        last = None if cut else self._last
        gap = 1.0 if memory is None else memory.gap
        self._last = None if seen is None else self._placed(image, seen, last, given, gap)
        if seen is None or self._last is None:
            return HeadFrame(image, given, cut=cut)
        lit, white, face = None, False, SeenFace(seen, self._last)
        if motion.light is not None:
            lit = motion.light.balanced(image, seen)
            white = lit is not image and motion.light.too_bright(image, seen)
        frame = HeadFrame(image, self._last.pose, face, balanced=lit, cut=cut, bright=white)
        if not is_grey(image, seen.pixels, motion.grey_below):
            return frame
        if motion.light is None:
            return frame._replace(grey=True)
        dark = motion.light.too_dark(image, seen)
        return frame._replace(grey=dark or not motion.light.same_hue(image, seen), dark=dark)

    def _placed(
        self,
        image: Image,
        seen: Landmarks,
        last: FrameLandmarks | None,
        given: Pose | None,
        gap: float,
    ) -> FrameLandmarks | None:
        """Pose and posture of a frame in which a face is seen; None where there is no such head.

        It comes a `gap`, in frames, after the `last` one.
        """
        motion = self._motion
        if self._given is None:
            return placed_fit(motion.textured, motion.shape, image, seen, last, gap / motion.rate)
        if given is None:
            return None
        held = HeldPose(given, np.diag(1 / np.square(HEAD_POSE.given_deviation)))
        found = fit_frame(motion.shape, seen, motion.textured.camera, last, held)
        return found if found.sound(motion.shape) else None

    def finish(self) -> None:
        """Any number of frames will do, or as many as there are given poses."""
        if self._given is not None:
            self._given.finish()
