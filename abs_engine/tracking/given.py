"""The head's motion where it is known: poses that were measured elsewhere, one for each frame."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.tracking.landmark_motion import HeadFrame

FloatArray = NDArray[np.float64]
Image = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class GivenMotion:
    """Stands in for `HeadMotion`: no face is looked for and nothing is followed.

    Parameters
    ----------
    given : tuple of (Pose or None)
        Head to camera in each frame; None where it is not known.
    """

    given: tuple[Pose | None, ...]

    def poses(self, frames: Iterable[Image]) -> Iterator[tuple[Image, Pose | None]]:
        """Each frame with its pose.

        Raises
        ------
        ParameterError
            If there are more or fewer frames.
        """
        count = 0
        for count, image in enumerate(frames, 1):
            if count > len(self.given):
                raise other_count(len(self.given), f"more than {len(self.given)}")
            yield image, self.given[count - 1]
        if count < len(self.given):
            raise other_count(len(self.given), str(count))

    def frames(self, images: Iterable[Image]) -> Iterator[HeadFrame]:
        """Each frame with its pose, for the tracker."""
        return (HeadFrame(image, pose) for image, pose in self.poses(images))

    def seen(self, camera: Camera, point: FloatArray) -> GivenMotion:
        """Only the poses that put a point (3,), mm, head frame, before the camera in its picture.

        Frames are learned from whose mouth can be there.
        """
        return GivenMotion(tuple(p if _inside(p, camera, point) else None for p in self.given))


def other_count(given: int, frames: str) -> ParameterError:
    """What is said of poses that are too many or too few."""
    return ParameterError(
        f"there are {given} poses for {frames} frames",
        "give one for each frame of the video, empty or NaN where it is not known",
    )


def _inside(pose: Pose | None, camera: Camera, point: FloatArray) -> bool:
    if pose is None or pose.apply(point)[2] <= 0:
        return False
    width, height = camera.size
    x, y = camera.project(pose.apply(point))
    return bool(0 <= x < width and 0 <= y < height)
