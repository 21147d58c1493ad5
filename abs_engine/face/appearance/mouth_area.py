"""Knowledge of where in a patch a mouth is, before its colours are compared."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from abs_engine.core.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class MouthPlace:
    """Knowledge of a mouth's place in a patch; maps are (H, W) float64, 0 to 1.

    `upper` is how probably a lip that is seen there would be the upper one; `within` and `beyond`
    how surely the pixel lies within the outline of the lips, and outside of it. Over `mixing` px,
    at least 1, a video's coarse chroma mixes neighbouring colours.
    """

    upper: FloatArray
    within: FloatArray
    beyond: FloatArray
    mixing: float = 1.0

    def mixed(self, shown: FloatArray) -> FloatArray:
        """The most that a map (N,) shows as near to each pixel as chroma mixes, but not beyond."""
        inside = shown * (1 - self.beyond.ravel())
        across = 2 * round(self.mixing) + 1
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (across, across))
        return np.asarray(cv2.dilate(inside.reshape(self.beyond.shape), disc).ravel(), np.float64)
