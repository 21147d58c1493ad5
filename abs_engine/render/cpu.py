"""The CPU rasteriser: plain loops compiled by numba, behind the `Renderer` protocol.

It is the oracle of the OpenGL renderer's tests, and what runs where no OpenGL loads.
"""

from __future__ import annotations

import threading
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.buffers import Buffers, Outlines, Sums
from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import Candidates, ClassMaps, PixelTerm, Renderer, Scene
from abs_engine.render import fused, layers, pixel_kernels
from abs_engine.render.pixelsum import colour_error
from abs_engine.render.vertex import motion_of, weights_of

_ORDERED = 64  # drawings with one order of facets
_KEPT = 16  # sizes of drawings whose arrays are kept


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
        """Description of the renderer."""
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
        """Draw every candidate; see `compare.sums.outlined`."""
        clip, found = camera.clip_matrix(window), []
        for i in range(len(candidates)):
            given, scratch = self._given(scene, candidates, i, camera, window, clip)
            facet, shown = (np.empty(scratch.facet.shape, np.int32) for _ in range(2))
            depth = np.empty(facet.shape, np.float32)
            bary = np.empty((*facet.shape, 3), np.float32)
            fused.outlined(*given, facet, scene.facet_class, shown, depth, bary)
            scratch.drew(facet)
            found.append(Outlines(facet, shown, depth, bary))
        return found

    def measure(
        self, scene: Scene, candidates: Candidates, camera: Camera, window: Window, term: PixelTerm
    ) -> Sums:
        """Draw every candidate and sum `term` over its drawn pixels; see `Renderer.measure`.

        Raises
        ------
        ParameterError
            If candidates, scene, window and term do not fit together.
        """
        check_term(term, window)
        check_classes(scene, term)
        clip = camera.clip_matrix(window)
        total = np.empty(len(candidates), np.float64)
        pixels = np.empty(len(candidates), np.int64)
        for i in range(len(candidates)):
            given, scratch = self._given(scene, candidates, i, camera, window, clip)
            if isinstance(term, ClassMaps):
                total[i], pixels[i] = fused.measured(
                    *given, scratch.facet, scene.facet_class, term.maps
                )
            else:
                positions = fused.drawn(*given, scratch.facet)
                _texture_uv(scene, positions, scratch)
                total[i], pixels[i] = colour_error(scratch.uv, scene, term, candidates.weights[i])
            scratch.drew(scratch.facet)
        return Sums(total, pixels)

    def close(self) -> None:
        """Forget this thread's scratch arrays."""
        self._local = threading.local()

    def _given(
        self,
        scene: Scene,
        candidates: Candidates,
        index: int,
        camera: Camera,
        window: Window,
        clip: NDArray[np.float64],
    ) -> tuple[Any, _Scratch]:
        """First arguments of the functions of `fused`, and this thread's scratch arrays."""
        scratch = self._scratch(window.drawn, scene.faces)
        limit = camera.radius_limit if camera.distorted else 0.0
        weights, motion = weights_of(scene, candidates, index), motion_of(candidates, index)
        place = scene.mean, scene.modes, weights, motion, camera.distortion, limit, clip
        order, first = scratch.order
        depths = camera.near, camera.far, scene.cull
        return (*place, scene.faces, order, first, *depths, scratch.keys), scratch

    def _scratch(self, size: tuple[int, int], faces: NDArray[np.int32]) -> _Scratch:
        """Arrays of the calling thread for drawings of a size of some facets."""
        kept: dict[Any, _Scratch] = self._local.__dict__
        found = kept.get((size, id(faces)))
        if found is None:
            if len(kept) >= _KEPT:
                kept.clear()
            found = kept[size, id(faces)] = _Scratch(size, faces)
        return found

    def _buffers(
        self,
        scene: Scene,
        candidates: Candidates,
        index: int,
        clip: NDArray[np.float64],
        camera: Camera,
        window: Window,
    ) -> Buffers:
        given, scratch = self._given(scene, candidates, index, camera, window, clip)
        positions = fused.drawn(*given, scratch.facet)
        facet = scratch.facet.copy()
        depth = np.zeros(facet.shape, np.float32)
        bary = np.zeros((*facet.shape, 3), np.float32)
        rgb = np.zeros((*facet.shape, 3), np.float32)
        pixel_kernels.shade(
            positions, scene.faces, scene.uv, scene.texture, facet, depth, bary, rgb
        )
        if scene.texture_modes is not None:
            _texture_uv(scene, positions, scratch)
            rgb = layers.colours(scratch.uv, scene, candidates.weights[index])
        class_of = np.concatenate([np.zeros(1, np.int32), scene.facet_class])
        return Buffers(rgb, facet, class_of[facet], depth, bary)


class _Scratch:
    """Arrays that are written anew for every candidate, and the order that facets are drawn in."""

    def __init__(self, size: tuple[int, int], faces: NDArray[np.int32]) -> None:
        (width, height), self.faces = size, faces
        self.keys = np.empty(height * width, np.int64)
        self.facet = np.empty((height, width), np.int32)
        self.uv = np.empty((height, width, 2), np.float32)
        self.order = np.arange(len(faces), dtype=np.int32), len(faces)
        self._drawings = 0

    @cached_property
    def planes(self) -> NDArray[np.float64]:
        """Scratch of `pixel_kernels.texture_uv`."""
        return np.empty((len(self.faces), 9), np.float64)

    @cached_property
    def known(self) -> NDArray[np.uint8]:
        """Likewise."""
        return np.empty(len(self.faces), np.uint8)

    def drew(self, facet: NDArray[np.int32]) -> None:
        """Begin later drawings with what is seen in this one, now and then."""
        if self._drawings % _ORDERED == 0:
            seen = np.zeros(len(self.faces) + 1, bool)
            seen[facet.ravel()] = True
            seen = seen[1:]
            order = np.concatenate([np.flatnonzero(seen), np.flatnonzero(~seen)])
            self.order = order.astype(np.int32), int(seen.sum())
        self._drawings += 1


def _texture_uv(scene: Scene, positions: NDArray[np.float32], scratch: _Scratch) -> None:
    """Texture coordinates of the pixels that were rasterised last, into `scratch.uv`."""
    pixel_kernels.texture_uv(
        positions, scene.faces, scene.uv, scratch.facet, scratch.planes, scratch.known, scratch.uv
    )


def check_classes(scene: Scene, term: PixelTerm) -> None:
    """Raise `ParameterError` if a facet's class has no map."""
    if isinstance(term, ClassMaps) and scene.highest_class >= len(term.maps):
        raise ParameterError(
            f"the scene has class {scene.highest_class}, the term only {len(term.maps)} maps",
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


def for_threads(renderer: Renderer) -> Renderer:
    """The renderer itself if several threads may draw with it at once, else the CPU rasteriser.

    For what is drawn ahead of the fits, or of several frames at once: an OpenGL context belongs to
    one thread.
    """
    return renderer if getattr(renderer, "concurrent", False) else CpuRenderer()
