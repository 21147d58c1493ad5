"""Colours of a video's pixels, their chromaticity from equally coarse chroma and luminance.

Video keeps chroma at half the resolution of luminance (4:2:0). Where a square of 2x2 pixels lies
across an edge, its pixels have luminances of their own, but the chroma of both sides: lips beside
the dark of a mouth come out too pale for their luminance, as teeth are, and the dark between closed
lips too red. Chromaticity (r, g) is therefore that of a picture in which both are smoothed, and
only luminance is as fine as in the video.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.camera import Window
from abs_engine.face.appearance.luminance import luminance

CHROMA_REACH = 2.0  # pixels of the video that share one chroma sample, along each axis
_BINOMIAL = np.array([0.25, 0.5, 0.25])  # about as wide as chroma of half the resolution
_REACH = 4.0  # of standard deviations that a window drawn coarsely is smoothed by


def matched(image: NDArray[np.generic]) -> NDArray[np.float32]:
    """Every pixel of an image with the chromaticity of its neighbourhood and its own luminance.

    Of an image (H, W, 3), RGB 0 to 255, at the video's own resolution; from -1 on, and beyond 255
    at bright edges. `features` of it has exactly the smoothed picture's r and g, and the picture's
    y.
    """
    fine = np.asarray(image, np.float32)
    smooth = cv2.sepFilter2D(fine, -1, _BINOMIAL, _BINOMIAL, borderType=cv2.BORDER_REPLICATE)
    ratio = (luminance(fine) + 1) / (luminance(smooth) + 1)
    return np.asarray((smooth + 1) * ratio[..., None] - 1, np.float32)


def sampled(window: Window, image: NDArray[np.generic]) -> NDArray[np.generic]:
    """The colours (h, w, 3) in a window of a frame, as `Window.sample` has them, but `matched`."""
    margin = 2 + int(np.ceil(_REACH * 0.5 / min(window.scale, 1.0)))
    x, right = _part(window.x, window.width, margin, image.shape[1])
    y, bottom = _part(window.y, window.height, margin, image.shape[0])
    moved = Window(window.x - x, window.y - y, window.width, window.height, window.scale)
    return moved.sample(matched(image[y:bottom, x:right]))


def _part(start: float, length: float, margin: int, size: int) -> tuple[int, int]:
    """Bounds of the pixels about a window, along one axis; where it is beyond, at the border."""
    low, high = np.clip([np.floor(start), np.ceil(start + length)], 0, size)
    return max(0, int(low) - margin), min(size, int(high) + margin)
