"""A person's head followed by its landmarks and its texture, each frame on its own."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.geometry import Pose
from abs_engine.tracking.faces import FaceChoice, FaceFollower
from abs_engine.tracking.head_pose import TexturedHead, placed_fit
from abs_engine.tracking.landmark_fit import FrameLandmarks
from abs_engine.tracking.landmark_shape import LandmarkShape
from abs_engine.tracking.landmarks import Landmarks

Image = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class SeenFace:
    """A face's landmarks, and what they say of the head.

    Parameters
    ----------
    landmarks : Landmarks
    fit : FrameLandmarks
    """

    landmarks: Landmarks
    fit: FrameLandmarks


class HeadFrame(NamedTuple):
    """A frame, and where its head is.

    Parameters
    ----------
    image : (H, W, 3) uint8 RGB
    pose : Pose or None
        None where the face was not found.
    face : SeenFace or None
        None where the landmark network was not asked.
    """

    image: Image
    pose: Pose | None
    face: SeenFace | None = None


@dataclass(frozen=True, eq=False)
class LandmarkMotion:
    """Stands in for `HeadMotion` where the person's head was fitted to landmarks.

    Parameters
    ----------
    shape : LandmarkShape
        Of the person.
    textured : TexturedHead
    choice : FaceChoice
    """

    shape: LandmarkShape
    textured: TexturedHead
    choice: FaceChoice = field(default_factory=FaceChoice)

    def frames(self, images: Iterable[Image]) -> Iterator[HeadFrame]:
        """Each frame with the head's pose and posture."""
        follower, last = FaceFollower(self.choice), None
        for image in images:
            seen = follower.step(image)
            last = (
                None if seen is None else placed_fit(self.textured, self.shape, image, seen, last)
            )
            if seen is None or last is None:
                yield HeadFrame(image, None)
                continue
            yield HeadFrame(image, last.pose, SeenFace(seen, last))
