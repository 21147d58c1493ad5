"""Pictures with smooth edges: several samples a pixel, by whichever renderer there is."""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol, runtime_checkable

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.camera import Camera, Window
from abs_engine.core.scene import Candidates, Renderer, Scene

SAMPLES = 8
"""Samples a pixel of a multisampled picture."""
FINER = 3
"""Drawn pixels a side for each pixel of a supersampled picture."""
SMALL = 600
"""Multisampled pictures of less width and height are drawn twice as fine, too: their texture,
which is read once for each pixel and facet, is much finer than they are."""


@runtime_checkable
class Multisampling(Protocol):
    """A renderer that makes multisampled pictures, as `OpenGLRenderer` does."""

    def picture(
        self, scene: Scene, candidates: Candidates, camera: Camera, window: Window, samples: int = 4
    ) -> list[NDArray[np.uint8]]:
        """Pictures (H, W, 3) uint8 RGB, the background black."""
        ...


def smooth_picture(
    renderer: Renderer, scene: Scene, candidate: Candidates, camera: Camera, window: Window
) -> NDArray[np.float32]:
    """The mean of several samples in each pixel, (H, W, 3) float32 RGB, 0 to 255, on black.

    OpenGL multisamples. Other renderers are asked for a finer picture, which is averaged.

    Parameters
    ----------
    candidate : Candidates
        A batch of one.
    """
    drawn: NDArray[np.uint8] | NDArray[np.float32]
    if isinstance(renderer, Multisampling):
        finer = _finer(window, 2 if max(window.drawn) < SMALL else 1)
        drawn = renderer.picture(scene, candidate, camera, finer, SAMPLES)[0]
    else:
        drawn = renderer.draw(scene, candidate, camera, _finer(window, FINER))[0].rgb
    fine = np.asarray(drawn, np.float32)
    return np.asarray(cv2.resize(fine, window.drawn, interpolation=cv2.INTER_AREA), np.float32)


def _finer(window: Window, times: int) -> Window:
    return replace(window, scale=times * window.scale)
