"""The camera before which something is drawn, and how it is turned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera, Window
from abs_engine.core.geometry import FACING, Pose

DISTANCE = 1000.0
"""From the camera to the middle of what is shown, mm."""
FILLED = 0.94
"""Share of the picture's width or height that is filled."""


@dataclass(frozen=True, eq=False)
class View:
    """A camera, the pose of a surface before it, and the window that is drawn.

    Parameters
    ----------
    pose : Pose
        Of what is drawn, to the camera.
    """

    camera: Camera
    pose: Pose
    window: Window

    def pixels(self, points: FloatArray) -> FloatArray:
        """Places in the drawn window of points (N, 3), mm, of what stands there, (N, 2)."""
        return self.window.to_drawn(self.camera.project(self.pose.apply(points)))


def views_of(
    points: FloatArray, size: tuple[int, int], turns: Sequence[float] = (0.0,)
) -> list[View]:
    """Views of a surface at one scale, in the middle of the picture.

    Parameters
    ----------
    points : (N, 3) float64, mm, head frame
        What has to be in every picture.
    size : tuple of int
        Width and height, pixels.
    turns : sequence of float
        Degrees by which the head turns to its left, one for each view.
    """
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    poses = []
    for turn in np.radians(turns):  # about a vertical axis through the centre
        rotation = FACING @ Pose.from_vectors([0.0, turn, 0.0], np.zeros(3)).rotation
        poses.append(Pose(rotation, np.array([0.0, 0.0, DISTANCE]) - rotation @ centre))
    spread = np.concatenate([p[..., :2] / p[..., 2:] for p in (q.apply(points) for q in poses)])
    widest, highest = np.abs(spread).max(axis=0)
    focal = 0.5 * FILLED * min(size[0] / widest, size[1] / highest)
    camera = Camera.ideal(size, float(focal))
    return [View(camera, pose, camera.whole) for pose in poses]
