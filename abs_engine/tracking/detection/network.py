"""A shipped network, run by OpenCV; threads that use it at once have one each."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.settings import GENERAL
from abs_engine.io.assets import shipped

_ENGINE = ("ENGINE_CLASSIC",)
"""OpenCV's engine, where it has several: the newer one runs a network anew for each output."""


def square_of(
    part: Image, matrix: FloatArray, low: NDArray[np.int_], step: float, side: int, border: int
) -> Image:
    """A square of `side` pixels, as a network looks at it, that `matrix` (2, 3) maps to an image.

    One of its pixels is `step` of the image's. The part of the image that it lies in begins at
    `low` (2,), column and row; beyond it is what OpenCV's `border` makes.
    """
    if step > 1:  # else pixels would be skipped
        part = np.asarray(cv2.GaussianBlur(part, (0, 0), GENERAL.shrunk_blur * step), np.uint8)
    moved = matrix.copy()
    moved[:, 2] -= low
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    warped = cv2.warpAffine(part, moved, (side, side), flags=flags, borderMode=border)
    return np.asarray(warped, np.uint8)


class Network:
    """A network of `assets/detector`, loaded when it is first asked, and again for each beside it.

    Parameters
    ----------
    file : str
        Its name there.
    outputs : tuple of str
        The outputs that are wanted.
    """

    def __init__(self, file: str, *outputs: str) -> None:
        self._file, self._outputs = file, outputs
        self._idle: list[cv2.dnn.Net] = []

    def seen(self, picture: NDArray[np.float32]) -> list[NDArray[np.float32]]:
        """Its outputs for a picture (H, W, 3), all of one run."""
        try:
            own = self._idle.pop()
        except IndexError:  # all are in use
            own = self._loaded()
        own.setInput(picture.transpose(2, 0, 1)[None])
        found = own.forward(self._outputs)
        self._idle.append(own)
        return [np.asarray(one, np.float32) for one in found]

    def _loaded(self) -> cv2.dnn.Net:
        chosen = [getattr(cv2.dnn, name) for name in _ENGINE if hasattr(cv2.dnn, name)]
        return cv2.dnn.readNetFromTFLite(str(shipped(f"detector/{self._file}")), *chosen)
