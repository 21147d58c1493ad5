"""A person's head followed by its landmarks and its texture, each frame on its own."""

from __future__ import annotations

from dataclasses import dataclass, field

from abs_engine.core.arrays import Image
from abs_engine.core.threads import workers
from abs_engine.tracking.face_choice import FaceChoice, FaceFollower
from abs_engine.tracking.frame_state import HeadFrame, Memory, SeenFace
from abs_engine.tracking.head_pose import TexturedHead, placed_fit
from abs_engine.tracking.landmark_fit import FrameLandmarks
from abs_engine.tracking.landmark_shape import LandmarkShape
from abs_engine.tracking.landmarks import Landmarks
from abs_engine.tracking.light import SkinLight


@dataclass(frozen=True, eq=False)
class LandmarkMotion:
    """Stands in for `HeadMotion` where the person's head was fitted to landmarks.

    Parameters
    ----------
    shape : LandmarkShape
        Of the person.
    textured : TexturedHead
    choice : FaceChoice
    known : tuple of Landmarks or None
        Those of the first frames, which were looked at before.
    light : SkinLight, optional
        The clip's usual light; with it each frame comes in that light, too.
    """

    shape: LandmarkShape
    textured: TexturedHead
    choice: FaceChoice = field(default_factory=FaceChoice)
    known: tuple[Landmarks | None, ...] = ()
    light: SkinLight | None = None

    @property
    def alone(self) -> bool:
        """Whether it may be followed in a thread of its own, ahead of the fits."""
        return workers(self.textured.renderer) > 1

    def follower(self) -> LandmarkFollower:
        """Follower of the head from the first frame on."""
        return LandmarkFollower(self)


class LandmarkFollower:
    """Finds the head in each frame, by its landmarks and its texture."""

    def __init__(self, motion: LandmarkMotion) -> None:
        self._motion, self._faces = motion, FaceFollower(motion.choice, motion.known)
        self._last: FrameLandmarks | None = None

    def step(self, image: Image, _memory: Memory | None = None) -> HeadFrame:
        """The next frame with the head's pose and posture."""
        motion, seen, cut = self._motion, self._faces.step(image), self._faces.cut
        last = None if cut else self._last
        self._last = (
            None if seen is None else placed_fit(motion.textured, motion.shape, image, seen, last)
        )
        if seen is None or self._last is None:
            return HeadFrame(image, None, cut=cut)
        lit = None if motion.light is None else motion.light.balanced(image, seen)
        face = SeenFace(seen, self._last)
        return HeadFrame(image, self._last.pose, face, balanced=lit, cut=cut)

    def finish(self) -> None:
        """Any number of frames will do."""
