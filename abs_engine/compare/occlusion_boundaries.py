"""Pixels beside drawn occlusion boundaries, where a picture mixes what meets there."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.buffers import Buffers
from abs_engine.core.camera import Camera, Window
from abs_engine.face.settings.appearance import APPEARANCE

_STEEPEST = float(np.sqrt(1 - APPEARANCE.facing**2) / APPEARANCE.facing)
_AROUND = np.ones((3, 3), np.uint8)
_FAR = np.float32(1e6)  # mm: farther behind anything than a step of any surface


def off_outlines(buffers: Buffers, camera: Camera, window: Window) -> NDArray[np.bool_]:
    """Drawn pixels whose eight neighbours show the same surface, (H, W) bool.

    A neighbour does where it is drawn, and no farther before or behind than the next pixel of a
    surface is at `sight.FACING`, the flattest at which appearance is learned. Diagonal neighbours,
    which lie 1.4 times as far off, are held to the same: across them flatter surfaces are left out
    too. Pixels on the window's border are left out.

    Parameters
    ----------
    buffers : Buffers
        Of the window.
    camera : Camera
    window : Window
    """
    drawn = buffers.covered
    step = _STEEPEST / (float(camera.matrix[0, 0]) * window.scale) * buffers.depth
    depth = np.where(drawn, buffers.depth, -_FAR)
    inner = drawn & (buffers.depth - cv2.erode(depth, _AROUND) < step)
    inner &= cv2.dilate(depth, _AROUND) - buffers.depth < step
    inner[[0, -1]] = False
    inner[:, [0, -1]] = False
    return np.asarray(inner)
