"""A new renderer: it draws and does not compare; the engine then compares its buffers.

Try it: abs-engine track CLIP -o RUN --plugin examples/new_renderer.py --renderer coarse
"""

from dataclasses import replace

import numpy as np

from abs_engine import RENDERERS, Buffers, open_renderer


class Coarse:
    """Draws every second pixel and shows each twice."""

    description = "coarse: every second pixel of the CPU rasteriser"

    def __init__(self):
        self._own = open_renderer("cpu")

    def draw(self, scene, candidates, camera, window):
        half = replace(window, scale=window.scale / 2)
        width, height = window.drawn
        wide = [
            {name: np.repeat(np.repeat(a, 2, axis=0), 2, axis=1) for name, a in vars(one).items()}
            for one in self._own.draw(scene, candidates, camera, half)
        ]
        edge = lambda a: np.pad(a, [(0, 2), (0, 2)] + [(0, 0)] * (a.ndim - 2), "edge")  # noqa: E731
        return [Buffers(**{n: edge(a)[:height, :width] for n, a in one.items()}) for one in wide]

    def close(self):
        self._own.close()

    __enter__, __exit__ = (lambda self: self), (lambda self, *_: self.close())


RENDERERS.add("coarse", Coarse)
