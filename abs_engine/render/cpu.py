"""The CPU rasteriser: plain loops compiled by numba, behind the `Renderer` protocol.

It is the oracle of the OpenGL renderer's tests, and what runs where no OpenGL loads.
"""

from __future__ import annotations

import threading
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.buffers import Buffers, Outlines, Sums
from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import Candidates, ClassMaps, PixelTerm, Scene
from abs_engine.render import kernels, layers
from abs_engine.render.pixelsum import colour_error
from abs_engine.render.vertex import clip_positions

_HIGHEST_CLASS: WeakKeyDictionary[Scene, int] = WeakKeyDictionary()


class CpuRenderer:
    """Draws with one thread and without any OpenGL; the GIL is released while it draws.

    Several threads may draw with the same renderer at once.
    """

    def __init__(self) -> None:
        self._local = threading.local()

    def __enter__(self) -> CpuRenderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def description(self) -> str:
        """What draws."""
        return "cpu: numba rasteriser, no OpenGL"

    @property
    def concurrent(self) -> bool:
        """Whether several threads may draw with it at once."""
        return True

    def draw(
        self, scene: Scene, candidates: Candidates, camera: Camera, window: Window
    ) -> list[Buffers]:
        """Draw every candidate; see `Renderer.draw`."""
        clip = camera.clip_matrix(window)
        return [
            self._buffers(scene, candidates, i, clip, camera, window)
            for i in range(len(candidates))
        ]

    def outlines(
        self, scene: Scene, candidates: Candidates, camera: Camera, window: Window
    ) -> list[Outlines]:
        """Draw every candidate; see `OutliningRenderer.outlines`."""
        clip, found = camera.clip_matrix(window), []
        for i in range(len(candidates)):
            positions = clip_positions(scene, candidates, i, camera, clip)
            facet = self._rasterise(scene, positions, camera, window).facet.copy()
            shown = np.empty(facet.shape, np.int32)
            depth = np.empty(facet.shape, np.float32)
            bary = np.empty((*facet.shape, 3), np.float32)
            given = positions, scene.faces, facet, scene.facet_class
            kernels.outlines(*given, shown, depth, bary)
            found.append(Outlines(facet, shown, depth, bary))
        return found

    def measure(
        self,
        scene: Scene,
        candidates: Candidates,
        camera: Camera,
        window: Window,
        term: PixelTerm,
    ) -> Sums:
        """Draw every candidate and sum `term` over its drawn pixels; see `Renderer.measure`.

        Raises
        ------
        ParameterError
            If candidates, scene, window and term do not fit together.
        """
        check_term(term, window)
        if isinstance(term, ClassMaps):
            _check_classes(scene, term)
        clip = camera.clip_matrix(window)
        total = np.empty(len(candidates), np.float64)
        pixels = np.empty(len(candidates), np.int64)
        for i in range(len(candidates)):
            positions = clip_positions(scene, candidates, i, camera, clip)
            scratch = self._rasterise(scene, positions, camera, window)
            total[i], pixels[i] = _sum(scene, positions, scratch, term, candidates.weights[i])
        return Sums(total, pixels)

    def close(self) -> None:
        """Forget this thread's scratch arrays."""
        self._local = threading.local()

    def _rasterise(
        self, scene: Scene, positions: NDArray[np.float32], camera: Camera, window: Window
    ) -> _Scratch:
        size = *window.drawn, len(scene.faces)
        scratch: _Scratch | None = getattr(self._local, "scratch", None)
        if scratch is None or scratch.size != size:
            scratch = self._local.scratch = _Scratch(size)
        kernels.rasterise(
            positions, scene.faces, camera.near, camera.far, scene.cull, scratch.keys, scratch.facet
        )
        return scratch

    def _buffers(
        self,
        scene: Scene,
        candidates: Candidates,
        index: int,
        clip: NDArray[np.float64],
        camera: Camera,
        window: Window,
    ) -> Buffers:
        positions = clip_positions(scene, candidates, index, camera, clip)
        scratch = self._rasterise(scene, positions, camera, window)
        facet = scratch.facet.copy()
        depth = np.zeros(facet.shape, np.float32)
        bary = np.zeros((*facet.shape, 3), np.float32)
        rgb = np.zeros((*facet.shape, 3), np.float32)
        kernels.shade(positions, scene.faces, scene.uv, scene.texture, facet, depth, bary, rgb)
        if scene.texture_modes is not None:
            _texture_uv(scene, positions, scratch)
            rgb = layers.colours(scratch.uv, scene, candidates.weights[index])
        class_of = np.concatenate([np.zeros(1, np.int32), scene.facet_class])
        return Buffers(rgb, facet, class_of[facet], depth, bary)


class _Scratch:
    """Arrays that are written anew for every candidate.

    Parameters
    ----------
    size : tuple of int
        Width and height in drawn pixels, number of facets.
    """

    def __init__(self, size: tuple[int, int, int]) -> None:
        width, height, facets = self.size = size
        self.keys = np.empty(height * width, np.int64)
        self.facet = np.empty((height, width), np.int32)
        self.uv = np.empty((height, width, 2), np.float32)
        self.planes = np.empty((facets, 9), np.float64)
        self.known = np.empty(facets, np.uint8)


def _sum(
    scene: Scene,
    positions: NDArray[np.float32],
    scratch: _Scratch,
    term: PixelTerm,
    weights: NDArray[np.float64],
) -> tuple[float, int]:
    """The term's sum over the drawn pixels, and their number."""
    if isinstance(term, ClassMaps):
        total, pixels = kernels.sum_class_maps(scratch.facet, scene.facet_class, term.maps)
        return float(total), int(pixels)
    _texture_uv(scene, positions, scratch)
    return colour_error(scratch.uv, scene, term, weights)


def _texture_uv(scene: Scene, positions: NDArray[np.float32], scratch: _Scratch) -> None:
    """Texture coordinates of the pixels that were rasterised last, into `scratch.uv`."""
    kernels.texture_uv(
        positions, scene.faces, scene.uv, scratch.facet, scratch.planes, scratch.known, scratch.uv
    )


def _check_classes(scene: Scene, term: ClassMaps) -> None:
    highest = _HIGHEST_CLASS.get(scene)
    if highest is None:
        highest = _HIGHEST_CLASS[scene] = int(scene.facet_class.max())
    if highest >= len(term.maps):
        raise ParameterError(
            f"the scene has class {highest}, the term only {len(term.maps)} maps",
            "give one map for each class id, and one for the background",
        )


def check_term(term: PixelTerm, window: Window) -> None:
    """Raise `ParameterError` unless the term's images have the window's drawn size."""
    width, height = window.drawn
    shape = term.maps.shape[1:] if isinstance(term, ClassMaps) else term.frame.shape[:2]
    if shape != (height, width):
        raise ParameterError(
            f"the pixel term is {shape[1]}x{shape[0]}, the window {width}x{height}",
            "sample it with the same window",
        )
