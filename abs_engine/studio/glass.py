"""Puts what a mirror shows into a picture."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.camera import Camera
from abs_engine.studio.mirror import Mirror

_SHINE = 0.9
"""Share of the light that the mirror gives back."""


@dataclass(frozen=True, eq=False)
class Drawn:
    """Buffers that the worker drew of a frame.

    Parameters
    ----------
    rgba : (H, W, 4) uint8
    ids : (H, W) uint16
    cover : (H, W) uint8
    depth : (H, W) float32, mm
        Of head and props.
    glass : (H, W) bool
        Where the mirror is what is seen.
    """

    rgba: NDArray[np.uint8]
    ids: NDArray[np.uint16]
    cover: NDArray[np.uint8]
    depth: NDArray[np.float32]
    glass: BoolArray


class Glass:
    """A mirror in one camera's picture."""

    def __init__(self, mirror: Mirror, camera: Camera) -> None:
        self.mirror, self._camera = mirror, camera
        self.mask, self.depth = mirror.mask(camera), mirror.depth(camera)

    def hides(self, points: FloatArray, pixels: FloatArray) -> BoolArray:
        """Whether the mirror stands before points (N, 3), camera frame, at pixels (N, 2)."""
        row, column = self._nearest(pixels)
        return np.asarray(self.depth[row, column] < points[:, 2])

    def shows(self, pixels: FloatArray) -> BoolArray:
        """Whether pixels (N, 2) lie on the mirror."""
        row, column = self._nearest(pixels)
        return np.asarray(self.mask[row, column])

    def _nearest(self, pixels: FloatArray) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        width, height = self._camera.size
        column = np.clip(np.rint(pixels[:, 0]), 0, width - 1).astype(np.intp)
        return np.clip(np.rint(pixels[:, 1]), 0, height - 1).astype(np.intp), column


def joined(direct: Drawn, mirrored: Drawn, glass: Glass) -> Drawn:
    """The direct view, with the mirror's picture where the mirror is what is seen.

    What stands between camera and mirror stays; what stands behind the mirror is hidden by it.
    """
    before = (direct.depth > 0) & (direct.depth < glass.depth)
    seen = glass.mask & ~before
    # Edges of what stands before the mirror are blended with what is in the mirror.
    edge = seen & (cv2.dilate(before.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0)
    alpha = np.where(edge, direct.rgba[..., 3], 0).astype(np.float32)[..., None] / 255
    inside = _SHINE * mirrored.rgba.astype(np.float32)
    inside[..., 3] += 255 * (1 - _SHINE)  # the background is seen in the mirror, too
    over = np.where(edge[..., None], direct.rgba.astype(np.float32), 0) + inside * (1 - alpha)
    rgba = np.where(seen[..., None], np.rint(over), direct.rgba).astype(np.uint8)
    return Drawn(
        rgba,
        np.where(seen, mirrored.ids, direct.ids).astype(np.uint16),
        np.where(seen, mirrored.cover, direct.cover).astype(np.uint8),
        np.where(seen, mirrored.depth, direct.depth).astype(np.float32),
        seen,
    )
