"""The test for pictures in one strong tint: night-vision green, a duotone, red light.

The chroma of such a picture changes with luminance alone, and smoothly. That of a face and of what
is around it does not, whatever their light.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.face.settings.tint import TINT

TO_CHROMA = np.array([[-0.169, -0.331, 0.5], [0.5, -0.419, -0.081], [0.299, 0.587, 0.114]])
"""RGB to blue chroma, red chroma and luminance."""


def untinted(picture: Image) -> Image:
    """A picture (H, W, 3) RGB itself, or in grey where it is in one strong tint.

    Networks know faces in grey, but do badly on some tints.
    """
    if not in_one_tint(picture):
        return picture
    return np.repeat(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)[..., None], 3, axis=2)


def in_one_tint(picture: Image) -> bool:
    """Whether a picture (H, W, 3) RGB of a face and what is around it is in one strong tint.

    A few cells do not count, such as those at an edge, whose colour is a mean of two.
    """
    down, across = (max(1, n // (TINT.samples * TINT.cells)) for n in picture.shape[:2])
    size = TINT.cells, TINT.cells
    small = cv2.resize(picture[::down, ::across], size, interpolation=cv2.INTER_AREA)
    cells = small.reshape(-1, 3)
    strength = float(np.sqrt(np.square(TO_CHROMA[:2] @ cells.T).sum(axis=0).mean()))
    return off_tint(cells, TINT.stray) < min(TINT.most_off, TINT.most_share * strength)


def off_tint(cells: NDArray[np.generic], stray: float = 0.0) -> float:
    """RMS distance of the chroma of cells (N, 3) from a smooth function of their luminance.

    In levels of 255; a share of the cells, `stray`, those that are farthest off, is left out.
    """
    seen = TO_CHROMA @ np.asarray(cells, np.float64).T
    luminance = seen[2]
    each, rest = divmod(len(luminance), TINT.levels)
    order = np.argsort(luminance, kind="stable")[rest // 2 :][: TINT.levels * each]
    usual = np.median(seen[:, order.reshape(TINT.levels, each)], axis=2)
    tint = np.linalg.lstsq(_powers(usual[2]), usual[:2].T)[0]
    powers = _powers(luminance)
    away = seen[:2].T - powers @ tint
    # chroma is coarser than luminance in video, so that at edges luminance is off, too
    slope = powers[:, :-1] @ (np.arange(1, len(tint))[:, None] * tint[1:])
    slope *= TINT.luminance_unsure / 255
    along = np.square((away * slope).sum(axis=1)) / (1 + np.square(slope).sum(axis=1))
    square = np.sort(np.square(away).sum(axis=1) - along)[: round((1 - stray) * len(away))]
    return float(np.sqrt(square.mean()))


def _powers(luminance: FloatArray) -> FloatArray:
    """Powers of luminances (N,), (N, 1 + degree), that a curve is a weighted sum of."""
    return np.vander(luminance / 255, TINT.degree + 1, increasing=True)
