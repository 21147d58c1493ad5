"""Scenes and pixel terms on the GPU, for as long as the Python object they came from."""

from __future__ import annotations

import weakref
from collections import deque
from collections.abc import Callable
from functools import cached_property
from typing import Any, Generic, Protocol, TypeVar

import moderngl
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.scene import ClassMaps, PixelTerm, Scene
from abs_engine.render.context import GLContext
from abs_engine.render.layout import Layout, class_layout, facet_layout
from abs_engine.render.programs import SKIN, SKIN_MODES, TEXTURE_WEIGHTS, set_uniform


class Releasable(Protocol):
    """Something with GL objects of its own."""

    def release(self) -> None:
        """Free them; the context must be current."""
        ...


K = TypeVar("K")
V = TypeVar("V", bound=Releasable)


class WeakCache(Generic[K, V]):
    """Uploads that `make` makes, by the identity of what they came from.

    When the Python object dies, its upload is only put aside: the garbage collector may run in
    another thread or while another context is current. `sweep` frees what was put aside.
    """

    def __init__(self, make: Callable[[K], V]) -> None:
        self._make = make
        self._entries: dict[int, tuple[weakref.ref[Any], V]] = {}
        self._dead: deque[V] = deque()

    def get(self, item: K) -> V:
        """The upload of `item`, made at first sight; the context must be current."""
        if self._dead:
            self.sweep()
        entry = self._entries.get(id(item))
        if entry is None:
            entry = weakref.ref(item, self._forget(id(item))), self._make(item)
            self._entries[id(item)] = entry
        return entry[1]

    def _forget(self, key: int) -> Callable[[Any], None]:
        entries, dead = self._entries, self._dead

        def forget(_: Any) -> None:
            entry = entries.pop(key, None)
            if entry is not None:
                dead.append(entry[1])

        return forget

    def sweep(self) -> None:
        """Free the uploads of dead objects; the context must be current."""
        while self._dead:
            self._dead.popleft().release()

    def release(self) -> None:
        """Free all; the context must be current."""
        self.sweep()
        while self._entries:
            self._entries.popitem()[1][1].release()

    def __len__(self) -> int:
        return len(self._entries)


class Labelled:
    """Facets that carry labels; the CPU places their vertices and selects which are drawn.

    `name` says of what the labels are; `buffer` and `reserve` make a buffer from an array, and an
    empty one of a number of bytes.
    """

    def __init__(
        self,
        name: str,
        layout: Layout,
        buffer: Callable[[NDArray[Any]], moderngl.Buffer],
        reserve: Callable[[int], moderngl.Buffer],
    ) -> None:
        self.name, self.layout, self._buffer, self._reserve = name, layout, buffer, reserve
        self.positions = np.empty((len(layout.source), 4), np.float32)
        self.kept = np.empty((len(layout.faces), 3), np.int32)

    @cached_property
    def vertex_buffer(self) -> moderngl.Buffer:
        """Clip coordinates of each vertex."""
        return self._reserve(self.positions.nbytes)

    @cached_property
    def kept_buffer(self) -> moderngl.Buffer:
        """Indices of the facets that are submitted."""
        return self._reserve(self.kept.nbytes)

    @cached_property
    def label_buffer(self) -> moderngl.Buffer:
        """Label of each vertex."""
        return self._buffer(self.layout.label)


class SceneUpload:
    """Buffers and vertex arrays of one scene. Everything is made when it is first needed."""

    def __init__(self, gl: GLContext, scene: Scene) -> None:
        self._ctx = gl.ctx
        self._owned: list[Any] = []
        self._arrays: dict[str, moderngl.VertexArray] = {}
        self._of_scene: dict[str, moderngl.Buffer] = {}
        self._weights: moderngl.Buffer | None = None
        # Not the scene itself: holding it would keep it alive, and this with it.
        self.n_vertices, self.n_facets = len(scene.mean), len(scene.faces)
        self._scene = weakref.ref(scene)
        self.by_class = Labelled("class", class_layout(scene), self._buffer, self._reserve)
        self.layout = self.by_class.layout
        self.kept_facets = np.empty(self.n_facets, np.int32)

    def _buffer(self, data: NDArray[Any]) -> moderngl.Buffer:
        # A buffer may not be empty; a scene without modes still binds one.
        buffer = self._ctx.buffer(np.ascontiguousarray(data)) if data.size else self._reserve(16)
        if data.size:
            self._owned.append(buffer)
        return buffer

    def _reserve(self, size: int) -> moderngl.Buffer:
        buffer = self._ctx.buffer(reserve=size, dynamic=True)
        self._owned.append(buffer)
        return buffer

    @property
    def _alive(self) -> Scene:
        scene = self._scene()
        if scene is None:
            raise ReferenceError("the scene of this upload is gone")
        return scene

    @cached_property
    def by_facet(self) -> Labelled:
        """The facets, each labelled with its own number."""
        return Labelled("facet", facet_layout(self._alive), self._buffer, self._reserve)

    @property
    def vertex_buffer(self) -> moderngl.Buffer:
        """Clip coordinates written by the CPU, one for each vertex of the layout."""
        return self.by_class.vertex_buffer

    @cached_property
    def kept_facets_buffer(self) -> moderngl.Buffer:
        """Their numbers, where a facet's own attributes are drawn."""
        return self._reserve(self.kept_facets.nbytes)

    @cached_property
    def index_buffer(self) -> moderngl.Buffer:
        """Indices of all facets of the layout."""
        return self._buffer(self.layout.faces)

    @cached_property
    def uv_buffer(self) -> moderngl.Buffer:
        """Texture coordinates of each vertex of the layout; the first V are the scene's."""
        return self._buffer(self._alive.uv[self.layout.source])

    @cached_property
    def source_buffer(self) -> moderngl.Buffer:
        """Scene vertex behind each vertex of the layout."""
        return self._buffer(self.layout.source)

    def buffer_of(self, name: str) -> moderngl.Buffer:
        """An array of the scene's own, such as "faces"."""
        if name not in self._of_scene:
            self._of_scene[name] = self._buffer(getattr(self._alive, name))
        return self._of_scene[name]

    @cached_property
    def texture(self) -> moderngl.Texture:
        """The skin."""
        pixels = self._alive.texture
        size = pixels.shape[1], pixels.shape[0]
        texture = self._ctx.texture(size, 3, np.ascontiguousarray(pixels), alignment=1)
        texture.filter = moderngl.NEAREST, moderngl.NEAREST  # texture.glsl interpolates
        self._owned.append(texture)
        return texture

    @property
    def texture_defines(self) -> tuple[str, ...]:
        """Definitions with which shaders that colour this scene are compiled."""
        return () if self._alive.texture_modes is None else ("TEXTURE_MODES",)

    @cached_property
    def texture_modes(self) -> moderngl.TextureArray:
        """Addition of each mode to the skin, a layer for each."""
        modes = self._alive.texture_modes
        if modes is None:
            raise ReferenceError("the texture of this scene does not vary")
        layers, height, width, _ = modes.shape
        texture = self._ctx.texture_array((width, height, layers), 3, modes, dtype="f4")
        texture.filter = moderngl.NEAREST, moderngl.NEAREST
        self._owned.append(texture)
        return texture

    def use_texture(self, program: Any, weights: NDArray[np.float64]) -> None:
        """Bind the skin, and what it depends on, for a program with `texture_defines`.

        `weights` (L, P) are of the modes, for each layer that is drawn or read.
        """
        self.texture.use(SKIN)
        if self.texture_defines:
            self.texture_modes.use(SKIN_MODES)
            rows = np.ascontiguousarray(weights, np.float32)
            if self._weights is None or self._weights.size < rows.nbytes:
                self._weights = self._reserve(rows.nbytes)
            self._weights.write(rows)
            self._weights.bind_to_storage_buffer(TEXTURE_WEIGHTS)
            set_uniform(program, "n_texture_modes", rows.shape[1])

    def vertex_array(
        self, name: str, make: Callable[[], moderngl.VertexArray]
    ) -> moderngl.VertexArray:
        """The vertex array of this name, made once."""
        array = self._arrays.get(name)
        if array is None:
            array = self._arrays[name] = make()
        return array

    def release(self) -> None:
        """Free everything; the context must be current."""
        for item in [*self._arrays.values(), *self._owned]:
            item.release()
        self._arrays.clear()
        self._owned.clear()


class TermUpload:
    """The images of one pixel term as a texture."""

    def __init__(self, gl: GLContext, term: PixelTerm) -> None:
        if isinstance(term, ClassMaps):
            count, height, width = term.maps.shape
            self.texture: Any = gl.ctx.texture_array(
                (width, height, count), 1, term.maps, dtype="f4"
            )
        else:
            height, width = term.frame.shape[:2]
            pixels = np.ascontiguousarray(term.normalised, np.float32)
            self.texture = gl.ctx.texture((width, height), 3, pixels, dtype="f4")
        self.texture.filter = moderngl.NEAREST, moderngl.NEAREST

    def release(self) -> None:
        """Free the texture; the context must be current."""
        self.texture.release()
