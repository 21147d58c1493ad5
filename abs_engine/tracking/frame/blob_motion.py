"""The head by the blob of its lips alone, followed by a Kalman filter (Basu et al., 5.2 and 5.3).

The blob tells where the lips are across the line of sight. Rotation and depth are those of the
first frame in which a face is found; the paper gives them by hand.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.tracking.detection.initial_pose import with_mouth_at
from abs_engine.tracking.frame.blobs import LipBlob, LipPrior, find_lips
from abs_engine.tracking.frame.frame_state import Follower, HeadFrame, Memory, Motion
from abs_engine.tracking.settings.blobs import BLOB_START


class LipFollower:
    """Finds the lips by colour in frame after frame; constant velocity in between.

    Parameters
    ----------
    rate : float, frames per second
    """

    def __init__(self, classes: ColourClasses, rate: float) -> None:
        self._classes, self._step = classes, 1.0 / rate
        self._filter: cv2.KalmanFilter | None = None
        self._width = self._area = 0.0
        self._missed = 0

    @property
    def expected(self) -> LipPrior | None:
        """Expected place of the lips, by the frames so far; None where nothing is known."""
        if self._filter is None:
            return None
        centre = np.asarray(self._filter.statePost[:2, 0], np.float64)
        spread = np.sqrt(
            np.diag(self._filter.errorCovPost)[:2] + (BLOB_START.reach * self._width) ** 2
        )
        return LipPrior(centre, np.asarray(spread, np.float64), self._area)

    def step(self, image: Image) -> LipBlob | None:
        """The lips in the next frame (H, W, 3) RGB; None where none are sure.

        Without sure lips for some time the whole picture is looked at.
        """
        if self._filter is not None:
            self._predict(self._filter)
        blob = find_lips(self._classes, image, self.expected)
        if blob is None or blob.posterior < BLOB_START.sure:
            self._missed += 1
            if self._missed * self._step >= BLOB_START.patience:
                self._filter = None
            return None
        self._missed = 0
        self._take(blob)
        return blob

    def _take(self, blob: LipBlob) -> None:
        self._width, self._area = float(blob.size[0]), blob.area
        if self._filter is None:
            self._filter = self._started(blob)
            return
        self._filter.measurementNoiseCov = np.eye(2) * (BLOB_START.noise * self._width) ** 2
        self._filter.correct(blob.centre.reshape(2, 1))

    def _started(self, blob: LipBlob) -> cv2.KalmanFilter:
        new = cv2.KalmanFilter(4, 2, 0, cv2.CV_64F)
        move = np.eye(4)
        move[:2, 2:] = np.eye(2) * self._step
        new.transitionMatrix, new.measurementMatrix = move, np.eye(2, 4)
        new.statePost = np.r_[blob.centre, 0.0, 0.0].reshape(4, 1)
        place, speed = (BLOB_START.noise * self._width) ** 2, (BLOB_START.speed * self._width) ** 2
        new.errorCovPost = np.diag([place, place, speed, speed])
        return new

    def _predict(self, known: cv2.KalmanFilter) -> None:
        t, change = self._step, (BLOB_START.jerk * self._width) ** 2
        one = np.array([[t**4 / 4, t**3 / 2], [t**3 / 2, t**2]]) * change
        known.processNoiseCov = np.kron(one, np.eye(2))
        known.predict()  # into the posterior state too, until it is corrected


@dataclass(frozen=True, eq=False)
class BlobMotion:
    """Puts the mouth where its blob is.

    Parameters
    ----------
    rate : float, frames per second
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


class BlobFollower(Follower):
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
        camera, mouth = self._motion.camera, self._motion.pivot
        pose = with_mouth_at(self._held, blob.centre, camera, mouth)
        return HeadFrame(image, pose, blob=blob)
