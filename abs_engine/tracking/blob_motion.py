"""The head by the blob of its lips alone, followed by a Kalman filter (Basu et al., 5.2 and 5.3).

The blob tells where the lips are across the line of sight. Rotation and depth are those of the
first frame in which a face is found; the paper gives them by hand.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.tracking.blob_filter import LipFollower
from abs_engine.tracking.frame_state import HeadFrame, Memory, Motion


@dataclass(frozen=True, eq=False)
class BlobMotion:
    """Puts the mouth where its blob is.

    Parameters
    ----------
    classes : ColourClasses
    rate : float
        Frames per second.
    camera : Camera
    pivot : (3,) float64, mm, head frame
        The mouth's middle.
    first : Motion
        What finds the face in the first frame.
    """

    classes: ColourClasses
    rate: float
    camera: Camera
    pivot: FloatArray
    first: Motion

    def follower(self) -> BlobFollower:
        """Filter that follows the mouth from the first frame on."""
        return BlobFollower(self)


class BlobFollower:
    """Follows the lips' blob, one frame after the other."""

    def __init__(self, motion: BlobMotion) -> None:
        self._motion = motion
        self._lips = LipFollower(motion.classes, motion.rate)
        self._first = motion.first.follower()
        self._held: Pose | None = None

    def step(self, image: Image, memory: Memory) -> HeadFrame:
        """The next frame with the mouth at its blob; None where none is sure."""
        if self._held is None:
            self._held = self._first.step(image, memory).pose
        blob = self._lips.step(image)
        if blob is None or self._held is None:
            return HeadFrame(image, None)
        return HeadFrame(image, self._at(self._held, blob.centre), blob=blob)

    def _at(self, held: Pose, centre: FloatArray) -> Pose:
        """A pose moved across the line of sight, so that the mouth's middle is seen at a centre."""
        camera, mouth = self._motion.camera, held.apply(self._motion.pivot)
        move = centre - camera.project(mouth)
        across = move * mouth[2] / np.diag(camera.matrix)[:2]
        return Pose(held.rotation, held.translation + np.r_[across, 0.0])

    def finish(self) -> None:
        """Any number of frames will do."""
