"""A shipped network, run by OpenCV, that threads use by turns."""

from __future__ import annotations

import threading
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.io.assets import shipped

_ENGINE = ("ENGINE_CLASSIC",)
"""OpenCV's engine, where it has several: the newer one runs a network anew for each output."""


class Network:
    """A network of `assets/detector`, loaded when it is first asked.

    Parameters
    ----------
    file : str
        Its name there.
    outputs : tuple of str
        The outputs that are wanted.
    """

    def __init__(self, file: str, *outputs: str) -> None:
        self._file, self._outputs = file, outputs
        self._one_at_a_time = threading.Lock()

    def seen(self, picture: NDArray[np.float32]) -> list[NDArray[np.float32]]:
        """Its outputs for a picture (H, W, 3), all of one run."""
        with self._one_at_a_time:
            self._loaded.setInput(picture.transpose(2, 0, 1)[None])
            found = self._loaded.forward(self._outputs)
        return [np.asarray(one, np.float32) for one in found]

    @cached_property
    def _loaded(self) -> cv2.dnn.Net:
        chosen = [getattr(cv2.dnn, name) for name in _ENGINE if hasattr(cv2.dnn, name)]
        return cv2.dnn.readNetFromTFLite(str(shipped(f"detector/{self._file}")), *chosen)
