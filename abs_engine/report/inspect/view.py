"""The camera of an inspection picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.camera import Camera, Window
from abs_engine.core.geometry import FACING, FloatArray, Pose
from abs_engine.report.inspect.body import Body

DISTANCE = 1000.0
"""From the camera to the middle of what is shown, mm."""
FILLED = 0.94
"""Share of the picture's width or height that is filled."""
MOUTH_MM = 42.0
"""What lies nearer than this to the middle of the lips is in the picture of the mouth."""


@dataclass(frozen=True, eq=False)
class View:
    """A camera, where the head stands before it, and the window that is drawn.

    Parameters
    ----------
    camera : Camera
    pose : Pose
        Head to camera.
    window : Window
    """

    camera: Camera
    pose: Pose
    window: Window


def views_of(
    body: Body, size: tuple[int, int], turns: Sequence[float] = (0.0,), crop: str = "head"
) -> list[View]:
    """Views of a head at one scale, in the middle of the picture.

    Parameters
    ----------
    body : Body
        At rest, so that the camera stands still while the face moves.
    size : tuple of int
        Width and height, pixels.
    turns : sequence of float
        Degrees by which the head turns to its left, one for each view.
    crop : {"head", "mouth"}

    Returns
    -------
    list of View
    """
    points = _shown(body, crop)
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    poses = [_turned(turn, centre) for turn in turns]
    spread = np.concatenate([p[..., :2] / p[..., 2:] for p in (q.apply(points) for q in poses)])
    widest, highest = np.abs(spread).max(axis=0)
    focal = 0.5 * FILLED * min(size[0] / widest, size[1] / highest)
    camera = Camera.ideal(size, float(focal))
    return [View(camera, pose, camera.whole) for pose in poses]


def _turned(degrees: float, centre: FloatArray) -> Pose:
    """The head turned to its left about a vertical axis through `centre`."""
    turn = Pose.from_vectors([0.0, np.radians(degrees), 0.0], np.zeros(3)).rotation
    rotation = FACING @ turn
    return Pose(rotation, np.array([0.0, 0.0, DISTANCE]) - rotation @ centre)


def _shown(body: Body, crop: str) -> NDArray[np.float64]:
    """The vertices (N, 3) that have to be in the picture."""
    if crop == "head":
        return body.vertices
    lips = body.vertices[body.speaker.lip_ring].mean(axis=0)
    near = np.linalg.norm(body.vertices - lips, axis=1) < MOUTH_MM
    return np.asarray(body.vertices[near])
