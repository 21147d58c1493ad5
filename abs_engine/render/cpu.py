"""The CPU rasteriser: plain loops compiled by numba, behind the `Renderer` protocol.

It is the oracle of the OpenGL renderer's tests, and what runs where no OpenGL loads.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from abs_engine.buffers import Buffers, Sums
from abs_engine.camera import Camera, Window
from abs_engine.errors import ParameterError
from abs_engine.render import kernels
from abs_engine.render.vertex import clip_positions
from abs_engine.scene import Candidates, ClassMaps, PixelTerm, Scene


class CpuRenderer:
    """Draws with one thread and without any OpenGL; the GIL is released while it draws."""

    def __init__(self) -> None:
        self._pool: dict[tuple[int, int], tuple[NDArray[np.float32], NDArray[np.int32]]] = {}

    def __enter__(self) -> CpuRenderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def description(self) -> str:
        """What draws."""
        return "cpu: numba rasteriser, no OpenGL"

    def draw(
        self, scene: Scene, candidates: Candidates, camera: Camera, window: Window
    ) -> list[Buffers]:
        """Draw every candidate; see `Renderer.draw`."""
        clip = camera.clip_matrix(window)
        return [
            self._buffers(scene, clip_positions(scene, candidates, i, camera, clip), camera, window)
            for i in range(len(candidates))
        ]

    def measure(
        self,
        scene: Scene,
        candidates: Candidates,
        camera: Camera,
        window: Window,
        term: PixelTerm,
    ) -> Sums:
        """Draw every candidate and sum `term`; see `Renderer.measure`."""
        check_term(term, window)
        clip = camera.clip_matrix(window)
        total = np.empty(len(candidates), np.float64)
        pixels = np.empty(len(candidates), np.int64)
        for i in range(len(candidates)):
            positions = clip_positions(scene, candidates, i, camera, clip)
            facet = self._rasterise(scene, positions, camera, window)[1]
            total[i], pixels[i] = self._sum(scene, positions, facet, term)
        return Sums(total, pixels)

    def close(self) -> None:
        """Forget the pooled buffers."""
        self._pool.clear()

    def _rasterise(
        self, scene: Scene, positions: NDArray[np.float32], camera: Camera, window: Window
    ) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        width, height = window.drawn
        if (width, height) not in self._pool:
            shape = height, width
            self._pool[width, height] = np.empty(shape, np.float32), np.empty(shape, np.int32)
        inverse_depth, facet = self._pool[width, height]
        kernels.rasterise(positions, scene.faces, camera.near, scene.cull, inverse_depth, facet)
        return inverse_depth, facet

    def _buffers(
        self, scene: Scene, positions: NDArray[np.float32], camera: Camera, window: Window
    ) -> Buffers:
        facet = self._rasterise(scene, positions, camera, window)[1].copy()
        depth = np.zeros(facet.shape, np.float32)
        bary = np.zeros((*facet.shape, 3), np.float32)
        rgb = np.zeros((*facet.shape, 3), np.float32)
        kernels.shade(positions, scene.faces, scene.uv, scene.texture, facet, depth, bary, rgb)
        class_of = np.concatenate([np.zeros(1, np.int32), scene.facet_class])
        return Buffers(rgb, facet, class_of[facet], depth, bary)

    @staticmethod
    def _sum(
        scene: Scene, positions: NDArray[np.float32], facet: NDArray[np.int32], term: PixelTerm
    ) -> tuple[float, int]:
        if isinstance(term, ClassMaps):
            total, pixels = kernels.sum_class_maps(facet, scene.facet_class, term.maps)
        else:
            total, pixels = kernels.sum_colour_error(
                positions, scene.faces, scene.uv, scene.texture, facet, term.normalised
            )
        return float(total), int(pixels)


def check_term(term: PixelTerm, window: Window) -> None:
    """Raise `ParameterError` unless the term's images have the window's drawn size."""
    width, height = window.drawn
    shape = term.maps.shape[1:] if isinstance(term, ClassMaps) else term.frame.shape[:2]
    if shape != (height, width):
        raise ParameterError(
            f"the pixel term is {shape[1]}x{shape[0]}, the window {width}x{height}",
            "sample it with the same window",
        )
