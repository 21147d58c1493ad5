"""A shipped network, run by OpenCV; threads that use it at once have one each."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.io.assets import shipped

_ENGINE = ("ENGINE_CLASSIC",)
"""OpenCV's engine, where it has several: the newer one runs a network anew for each output."""


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
