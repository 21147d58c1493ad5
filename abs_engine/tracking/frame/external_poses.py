"""The head's motion where it is known: poses that were measured elsewhere, one for each frame."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Camera
from abs_engine.core.errors import FaceNotFoundError, ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.tracking.frame.frame_state import HeadFrame, Memory


@dataclass(frozen=True, eq=False)
class GivenMotion:
    """Stands in for `HeadMotion`: no face is looked for and nothing is followed.

    Parameters
    ----------
    given : tuple of (Pose or None)
        Head to camera in each frame; None where it is not known.
    """

    given: tuple[Pose | None, ...]

    def follower(self) -> GivenFollower:
        """Source of the poses, one after the other."""
        return GivenFollower(self.given)

    def in_picture(self, camera: Camera, point: FloatArray, video: Path) -> GivenMotion:
        """Only the poses that put a point (3,), mm, head frame, into the camera's picture.

        Frames are learned from whose mouth can be there.

        Raises
        ------
        FaceNotFoundError
            If no pose does.
        """
        seen = tuple(p if _inside(p, camera, point) else None for p in self.given)
        if all(pose is None for pose in seen):
            raise FaceNotFoundError(
                f"with the given poses, the mouth is outside the picture in all frames of {video}",
                "check that they are of this video, and give the camera's calibration with "
                "--camera",
            )
        return GivenMotion(seen)


class GivenFollower:
    """Gives poses one after the other."""

    def __init__(self, given: tuple[Pose | None, ...]) -> None:
        self._given, self._count = given, 0

    def step(self, image: Image, _memory: Memory | None = None) -> HeadFrame:
        """The next frame with its pose.

        Raises
        ------
        ParameterError
            If there are more frames than poses.
        """
        self._count += 1
        if self._count > len(self._given):
            raise other_count(len(self._given), f"more than {len(self._given)}")
        return HeadFrame(image, self._given[self._count - 1])

    def finish(self) -> None:
        """Say that there are no more frames.

        Raises
        ------
        ParameterError
            If there are fewer than poses.
        """
        if self._count < len(self._given):
            raise other_count(len(self._given), str(self._count))


def other_count(given: int, frames: str) -> ParameterError:
    """Message about too many or too few poses."""
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
