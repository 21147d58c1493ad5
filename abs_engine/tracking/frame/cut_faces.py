"""Faces that the picture's border cuts off, of which the landmark network sees all the same.

It sees what lies beyond the border, too, and most often too near: by 7 % of the face's size where
a tenth of that lies outside (p01 to p08 of the strangers' clips, cut through or below the eyes),
so that eyes and lips seem to lie in the picture which do not.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.tracking.detection.landmarks import EYES, Landmarks
from abs_engine.tracking.frame.mouth_landmarks import LipLandmarks
from abs_engine.tracking.landmark.landmark_fit import FrameLandmarks, fit_frame
from abs_engine.tracking.landmark.landmark_shape import LandmarkShape
from abs_engine.tracking.settings.detection import DETECTION
from abs_engine.tracking.settings.frames import FRAME_LOOP

Size = tuple[int, int]


@dataclass(frozen=True, eq=False)
class MouthInPicture:
    """Test of whether a person's whole mouth lies in the picture, by the rest of a face.

    Parameters
    ----------
    modes : int
        Of the posture's, those of the mouth, which come first.
    """

    shape: LandmarkShape
    modes: int
    camera: Camera

    @cached_property
    def _lips(self) -> LipLandmarks:
        return LipLandmarks.of(self.shape, self.modes, self.camera)

    def whole(self, seen: Landmarks, start: FrameLandmarks | None = None) -> bool:
        """Whether it does; true of every face that is not cut off. `start` is a first fit."""
        trust = trust_at_border(seen, self.camera.size)
        if trust is None:
            return True
        if not trust.any():
            return False
        fit = fit_frame(self.shape, seen, self.camera, start, trust=trust)
        return self.shown(fit.pose, fit.posture[: self.modes])

    def shown(self, pose: Pose, posture: FloatArray | None = None) -> bool:
        """Whether it does in a pose, and a posture (P,), by default the average of speech."""
        mouth = np.zeros(self.modes) if posture is None else posture
        return self._lips.in_picture(pose, mouth) >= FRAME_LOOP.least_by_face


def trust_at_border(landmarks: Landmarks, size: Size) -> FloatArray | None:
    """Trust in landmarks (468,), 0 to 1, of a face that a picture of this size, px, cuts off.

    None where it does not: then all are trusted. Beyond the border it is 0, and grows within it; of
    a face that lies outside of the picture none is trusted.
    """
    trust = np.ones(len(landmarks.points))
    for inside in _inside(landmarks, size):
        beyond = -float(inside.min())
        if beyond > 0:
            margin = min(beyond, DETECTION.cut_margin * landmarks.size)
            trust *= np.clip(inside / max(margin, 1e-9), 0.0, 1.0)
    return None if trust.all() else trust


def shows_eyes(landmarks: Landmarks, size: Size) -> bool:
    """Whether both eyes lie in a picture of this size, px, and off a border that cuts the face."""
    corners = np.concatenate(EYES)
    least = DETECTION.eyes_inside * landmarks.size
    return all(
        inside.min() >= 0 or inside[corners].min() > least for inside in _inside(landmarks, size)
    )


def _inside(landmarks: Landmarks, size: Size) -> list[FloatArray]:
    """Distances of the landmarks (468,) inwards from each of the picture's borders, px."""
    pixels = landmarks.pixels
    return [*(pixels + 0.5).T, *(np.array(size) - 0.5 - pixels).T]
