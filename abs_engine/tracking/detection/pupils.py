"""Pupils by MediaPipe's iris network (Ablavatski et al. 2020), run by OpenCV.

"Real-time Pupil Tracking from Monocular Video for Digital Puppetry", arXiv:2006.11341. Corners of
eyes are seen by the landmark network where people usually have them; pupils are what a distance of
pupils was measured between.
"""

from __future__ import annotations

import cv2
import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.tracking.detection.landmarks import Landmarks
from abs_engine.tracking.detection.network import Network, square_of
from abs_engine.tracking.settings.detection import DETECTION

_NETWORK = Network("iris_landmark.tflite", "output_iris")

_EYES = ((33, 133, 159, 145), (362, 263, 386, 374))
"""Left and right end in an upright picture, upper and lower lid, of the right and the left eye."""
_SIDE = 64  # pixels that the network looks at
_AROUND = 2.3  # times an eye's width (as MediaPipe does)


def pupils_of(image: Image, landmarks: Landmarks) -> FloatArray | None:
    """The pupils (2, 2) of the subject's right and left eye in a picture (H, W, 3) RGB, pixels.

    None where an eye is not seen well: shut, outside of the picture, or turned away.
    """
    found: list[FloatArray] = []
    size = np.array(image.shape[1::-1])
    widths = [float(np.linalg.norm(np.subtract(*landmarks.pixels[list(e[:2])]))) for e in _EYES]
    if min(widths) < DETECTION.turned_eyes * max(widths):
        return None
    for mirrored, marks in zip((False, True), _EYES, strict=True):
        start, end, upper, lower = landmarks.pixels[list(marks)]
        width = float(np.linalg.norm(end - start))
        outside = (np.minimum(start, end) < 0).any() or (np.maximum(start, end) > size - 1).any()
        if (
            width < DETECTION.least_eye
            or outside
            or np.linalg.norm(upper - lower) < DETECTION.shut_eye * width
        ):
            return None
        found.append(_pupil(image, start, end, mirrored))
    return np.stack(found)


def _pupil(image: Image, start: FloatArray, end: FloatArray, mirrored: bool) -> FloatArray:
    """The middle (2,) of an iris between the ends of an eye.

    The network knows eyes on the left of a picture only; others are mirrored.
    """
    along = (end - start) / np.linalg.norm(end - start)
    step = _AROUND * float(np.linalg.norm(end - start)) / _SIDE
    axes = step * np.stack([along, [-along[1], along[0]]], axis=1)
    matrix = np.column_stack([axes, 0.5 * (start + end) - axes @ np.full(2, 0.5 * (_SIDE - 1))])
    patch = _cut(image, matrix, step)
    look = patch[:, ::-1] if mirrored else patch
    (iris,) = _NETWORK.seen(look.astype(np.float32) / 255.0)
    seen = iris.reshape(5, 3)[0, :2].astype(np.float64) - 0.5
    if mirrored:
        seen[0] = _SIDE - 1 - seen[0]
    return np.asarray(matrix[:, :2] @ seen + matrix[:, 2])


def _cut(image: Image, matrix: FloatArray, step: float) -> Image:
    """The square of `_SIDE` pixels that `matrix` (2, 3) maps to the image."""
    reach = int(np.ceil(_SIDE * step)) + 4
    middle = matrix[:, :2] @ np.full(2, 0.5 * _SIDE) + matrix[:, 2]
    low = np.clip(middle.astype(int) - reach, 0, np.array(image.shape[1::-1]) - 1)
    part = image[low[1] : low[1] + 2 * reach, low[0] : low[0] + 2 * reach]
    return square_of(part, matrix, low, step, _SIDE, cv2.BORDER_REPLICATE)
