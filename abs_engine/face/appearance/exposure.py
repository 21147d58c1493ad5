"""The exposure of a face: how much of it is burnt out, and how bright it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.face.appearance.luminance import luminance
from abs_engine.face.settings.colour import COLOURS


@dataclass(frozen=True)
class Exposure:
    """Burnt-out share of a face, and its brightness.

    Parameters
    ----------
    saturated : float
        Share of its pixels that have two channels at their upper limit: skin and lips are red, so
        red alone is there in well-exposed pictures of light skin, too.
    luminance : float
        Its median, 0 to 255.
    """

    saturated: float = 0.0
    luminance: float = 128.0

    @property
    def burnt(self) -> bool:
        """Whether so much of the face is white that lips, teeth and skin merge."""
        return self.saturated > COLOURS.most_saturated

    @property
    def dark(self) -> bool:
        """Whether the face is too dark for its chroma to be seen."""
        return self.luminance < COLOURS.least_light

    @classmethod
    def of(cls, faces: Sequence[tuple[NDArray[np.uint8], FloatArray]]) -> Exposure:
        """Exposure of a clip's face, the median of some of its frames; the usual one without any.

        `faces` are pictures (H, W, 3) RGB, and points (N, 2), px, whose hull the face fills; those
        outside of the picture do not count.
        """
        seen = [one for image, outline in faces if len(one := _pixels(image, outline))]
        if not seen:
            return cls()
        shares = [np.mean(np.sort(one, axis=1)[:, 1] >= COLOURS.limit) for one in seen]
        bright = [np.median(luminance(one)) for one in seen]
        return cls(float(np.median(shares)), float(np.median(bright)))


def colourless(video: Path, exposure: Exposure) -> str:
    """Reason why a video whose face shows no chroma has none, the beginning of a message."""
    if exposure.dark:
        return f"the face in {video} is too dark for its colours to be seen"
    return f"{video} has no colour"


def _pixels(image: NDArray[np.uint8], outline: FloatArray) -> NDArray[np.uint8]:
    """Pixels (N, 3) of a face that lie in the picture."""
    inside = np.zeros(image.shape[:2], np.uint8)
    cv2.fillConvexPoly(inside, cv2.convexHull(np.rint(outline).astype(np.int32)), 1)
    return np.asarray(image[inside > 0], np.uint8)


USUAL = Exposure()
"""That of a well-exposed face, where it was not measured."""
