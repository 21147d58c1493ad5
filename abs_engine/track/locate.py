"""Finding the face, and from its box the mouth and a first pose of the head."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
import skimage.data
from numpy.typing import NDArray
from skimage.feature import Cascade

from abs_engine.camera import Camera
from abs_engine.geometry import FACING, Pose

# At the face's depth a box of this detector is about 168 mm wide on renders of the bundled people,
# and 174 mm on the faces of the GRID clips if the outer corners of their eyes are 88 mm apart. The
# mouth's centre lies 0.805 of its height below its top.
BOX_WIDTH_MM = 175.0
MOUTH_HEIGHT = 0.805
MOUTH_WIDTH = 0.27


@dataclass(frozen=True)
class FaceBox:
    """A square around a face: left, top and side length, pixels."""

    x: float
    y: float
    size: float

    @property
    def mouth(self) -> tuple[float, float]:
        """Where the mouth's centre is expected, pixels."""
        return self.x + 0.5 * self.size, self.y + MOUTH_HEIGHT * self.size

    @classmethod
    def around_mouth(cls, x: float, y: float, width: float, height: float) -> FaceBox:
        """The face box that a mouth box (left, top, width, height) belongs to."""
        size = width / MOUTH_WIDTH
        return cls(x + width / 2 - size / 2, y + height / 2 - MOUTH_HEIGHT * size, size)


def find_face(image: NDArray[np.uint8]) -> FaceBox | None:
    """The largest frontal face of an image (H, W, 3) RGB, or None.

    Local binary patterns in a boosted cascade (Ahonen et al. 2004; Viola and Jones 2001), with
    the cascade that scikit-image ships. Overlapping detections are averaged.
    """
    scale = min(1.0, 360 / max(image.shape))
    small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    least, most = max(24, round(0.15 * min(small.shape[:2]))), min(small.shape[:2])
    found = _cascade().detect_multi_scale(
        img=small, scale_factor=1.05, step_ratio=1, min_size=(least, least), max_size=(most, most)
    )
    if not found:
        return None
    boxes = np.array([[b["c"], b["r"], b["width"]] for b in found], np.float64)
    best = boxes[boxes[:, 2].argmax()]
    offset = np.abs(boxes[:, :2] + boxes[:, 2:] / 2 - (best[:2] + best[2] / 2)).max(axis=1)
    same = (offset < 0.25 * best[2]) & (boxes[:, 2] > 0.7 * best[2])
    x, y, size = boxes[same].mean(axis=0) / scale
    return FaceBox(float(x), float(y), float(size))


@cache
def _cascade() -> Cascade:
    return Cascade(skimage.data.lbp_frontal_face_cascade_filename())


def first_pose(box: FaceBox, camera: Camera, mouth: NDArray[np.float64]) -> Pose:
    """An upright head that faces the camera, with its mouth where the box expects it.

    Parameters
    ----------
    box : FaceBox
    camera : Camera
    mouth : (3,) float64
        The mouth's centre, mm, head frame.
    """
    depth = camera.matrix[0, 0] * BOX_WIDTH_MM / box.size
    pixel = np.array([[box.mouth]], np.float64)
    x, y = cv2.undistortPoints(pixel, camera.matrix, camera.distortion)[0, 0]
    centre = np.array([x, y, 1.0]) * depth
    return Pose(FACING, centre - FACING @ mouth)
