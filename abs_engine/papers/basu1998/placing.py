"""The mouth's place in single frames: by its blob alone; and when that was known."""

from __future__ import annotations

import time
from dataclasses import dataclass

from abs_engine.core.arrays import Image
from abs_engine.core.geometry import Pose
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.tracking.blobs import find_lips
from abs_engine.tracking.external_poses import GivenMotion
from abs_engine.tracking.frame_state import Follower, HeadFrame, Memory


@dataclass(frozen=True, eq=False)
class BlobPlaces:
    """Depth and rotation are given, the place in the picture is that of the lips' blob (5.3).

    Parameters
    ----------
    given : tuple of (Pose or None)
        Head to camera in each frame.
    """

    given: tuple[Pose | None, ...]
    classes: ColourClasses

    def follower(self) -> BlobPlacer:
        """Filter that finds the blobs."""
        return BlobPlacer(self)


class BlobPlacer:
    """Finds the lips' blob in each frame by itself."""

    def __init__(self, motion: BlobPlaces) -> None:
        self._classes, self._poses = motion.classes, GivenMotion(motion.given).follower()

    def step(self, image: Image, memory: Memory) -> HeadFrame:
        """The next frame with its blob; without one, no pose."""
        frame, blob = self._poses.step(image, memory), find_lips(self._classes, image)
        return frame._replace(pose=None if blob is None else frame.pose, blob=blob)

    def finish(self) -> None:
        """Say that there are no more frames."""
        self._poses.finish()


class Clock:
    """Follows as another does, and remembers when it was done: then the fit begins."""

    def __init__(self, own: Follower) -> None:
        self._own, self.begun = own, 0.0

    def follower(self) -> Clock:
        """Follower of the blobs, which is this value itself."""
        return self

    def step(self, image: Image, memory: Memory) -> HeadFrame:
        """The next frame with the head's pose."""
        frame = self._own.step(image, memory)
        self.begun = time.perf_counter()
        return frame

    def finish(self) -> None:
        """Say that there are no more frames."""
        self._own.finish()
