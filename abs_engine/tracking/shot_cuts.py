"""Cuts of a film: frames that show another scene than the frame before."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.tracking.settings.detection import DETECTION


class ShotCuts:
    """Finds cuts in frame after frame, by how much of a coarse picture changes.

    Attributes
    ----------
    found : list of int
        Frames that begin another shot, counted from 0.
    """

    def __init__(self) -> None:
        self._last: FloatArray | None = None
        self._count = 0
        self.found: list[int] = []

    def step(self, image: Image) -> bool:
        """Whether the next frame (H, W, 3) RGB begins another shot; not the first frame."""
        now, last = _cells(image), self._last
        cut = last is not None and _changed(last, now) > DETECTION.most_changed
        if cut:
            self.found.append(self._count)
        self._last, self._count = now, self._count + 1
        return cut


def cut_line(frames: Sequence[int]) -> str:
    """Line about the frames that begin other shots."""
    shown = ", ".join(str(k) for k in frames[:5]) + (", ..." if len(frames) > 5 else "")
    return (
        f"the film is cut before frame{'s' if len(frames) > 1 else ''} {shown}: one person is "
        "assumed in all shots; if there are several, give a video of each"
    )


def _cells(image: Image) -> FloatArray:
    """The picture's brightness (16, 16), 0 to 255."""
    down, across = (max(1, n // 128) for n in image.shape[:2])
    brightness = image[::down, ::across].mean(axis=2, dtype=np.float32)
    return np.asarray(cv2.resize(brightness, (16, 16), interpolation=cv2.INTER_AREA), np.float64)


def _changed(one: FloatArray, other: FloatArray) -> float:
    """Share of the cells that change by more than a part of how much cells differ."""
    spread = max(min(one.std(), other.std()), 1.0)
    return float((np.abs(one - other) > DETECTION.change * spread).mean())
