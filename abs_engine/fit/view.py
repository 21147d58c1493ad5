"""A view: a frame, its camera, and the window that is compared."""

from __future__ import annotations

from dataclasses import dataclass

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Camera, Window
from abs_engine.core.pose import PoseFrame
from abs_engine.core.scene import Renderer
from abs_engine.face.appearance.mouth_area import MouthPlace


@dataclass(frozen=True, eq=False)
class View:
    """Frame and camera that a term is bound to, besides a face.

    Parameters
    ----------
    image : (H, W, 3) uint8 RGB
        The whole frame.
    camera : Camera
    renderer : Renderer
    frame : PoseFrame
        What the six numbers of the pose mean.
    window : Window
        The part of the frame that is compared, and how finely it is drawn.
    start : (6 + P,) float64
        Pose and posture that the face has, about.
    place : MouthPlace, optional
        Where in the window the mouth is known to be.
    """

    image: Image
    camera: Camera
    renderer: Renderer
    frame: PoseFrame
    window: Window
    start: FloatArray
    place: MouthPlace | None = None
