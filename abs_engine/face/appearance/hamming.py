"""The Hamming window that probability maps are smoothed with (Basu et al., section 5.1)."""

from __future__ import annotations

import cv2
import numpy as np

from abs_engine.core.arrays import FloatArray


def hamming(maps: FloatArray, width: float) -> FloatArray:
    """Convolve maps (C, H, W) with a separable Hamming window `width` px wide (Basu, 5.1)."""
    size = 2 * int(np.ceil(width / 2)) + 1
    offset = np.arange(size) - size // 2
    inside = np.abs(offset) <= width / 2
    window = np.where(inside, 0.54 + 0.46 * np.cos(2 * np.pi * offset / max(width, 1e-9)), 0.0)
    window /= window.sum()
    return np.stack(
        [cv2.sepFilter2D(m, -1, window, window, borderType=cv2.BORDER_REPLICATE) for m in maps]
    )
