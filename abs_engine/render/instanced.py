"""The instanced vertex path: shape, pose and projection on the GPU, a batch in one draw."""

from __future__ import annotations

from collections.abc import Iterator

import moderngl
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.buffers import Buffers, Outlines, Sums
from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import OpenGLError
from abs_engine.core.scene import Candidates, ClassMaps, PixelTerm, Scene
from abs_engine.render import facets, targets
from abs_engine.render.context import GLContext
from abs_engine.render.programs import CLIP, DRAWN, MAPS, TARGET, Programs, set_uniform
from abs_engine.render.thin import ThinPath
from abs_engine.render.upload import SceneUpload, TermUpload, WeakCache

LAYER_EXTENSIONS = {"GL_ARB_shader_viewport_layer_array"}
MAX_LAYERS = 1024
MAX_BYTES = 512 * 2**20
BYTES_PER_PIXEL = {targets.LABEL: 8, targets.TEXTURE_UV: 12, targets.ALL_BUFFERS: 36}
GROUP = 64
"""Work group size of deform.comp."""


def can_layer(gl: GLContext) -> bool:
    """Whether the driver lets the vertex shader choose the layer."""
    return gl.ctx.extensions >= LAYER_EXTENSIONS


class InstancedPath:
    """Batches into layers; made for GPUs.

    `scenes` and `terms` are uploads. Raises `OpenGLError` if the driver cannot choose the layer in
    the vertex shader.
    """

    def __init__(
        self,
        gl: GLContext,
        programs: Programs,
        pool: targets.TargetPool,
        scenes: WeakCache[Scene, SceneUpload],
        terms: WeakCache[PixelTerm, TermUpload],
    ) -> None:
        if not can_layer(gl):
            raise OpenGLError(
                f"{gl.renderer} lacks {', '.join(LAYER_EXTENSIONS)}", "use the thin vertex path"
            )
        self._gl, self._programs, self._pool = gl, programs, pool
        self._scenes, self._terms = scenes, terms
        self._thin = ThinPath(gl, programs, pool, scenes)
        self._scratch: dict[str, moderngl.Buffer] = {}

    def draw(
        self, scene: Scene, candidates: Candidates, camera: Camera, window: Window
    ) -> list[Buffers]:
        """Buffers of every candidate."""
        upload, out = self._scenes.get(scene), list[Buffers]()
        for part in _chunks(len(candidates), window, targets.ALL_BUFFERS):
            clips = self._deform(upload, candidates, part, camera, window)
            layers = part.stop - part.start
            target = self._pool.get((*window.drawn, layers), targets.ALL_BUFFERS)
            out += facets.draw_buffers(
                self._gl, self._programs, upload, clips, target, candidates.weights[part]
            )
        return out

    def outlines(
        self, scene: Scene, candidates: Candidates, camera: Camera, window: Window
    ) -> list[Outlines]:
        """Borders of every candidate, by the thin path: a number a pixel is read, not eight."""
        return self._thin.outlines(scene, candidates, camera, window)

    def picture(
        self,
        scene: Scene,
        candidates: Candidates,
        index: int,
        camera: Camera,
        window: Window,
        canvas: targets.Canvas,
    ) -> NDArray[np.uint8]:
        """A multisampled picture of one candidate."""
        upload = self._scenes.get(scene)
        clips = self._deform(upload, candidates, slice(index, index + 1), camera, window)
        weights = candidates.weights[index : index + 1]
        return facets.draw_picture(self._gl, self._programs, upload, clips, canvas, weights)

    def measure(
        self, scene: Scene, candidates: Candidates, camera: Camera, window: Window, term: PixelTerm
    ) -> Sums:
        """Sums of every candidate."""
        upload = self._scenes.get(scene)
        by_class = isinstance(term, ClassMaps)
        formats = targets.LABEL if by_class else targets.TEXTURE_UV
        total = np.empty(len(candidates), np.float64)
        pixels = np.empty(len(candidates), np.int64)
        for part in _chunks(len(candidates), window, formats):
            clips = self._deform(upload, candidates, part, camera, window)
            layers = part.stop - part.start
            target = self._pool.get((*window.drawn, layers), formats)
            self._render(upload, clips, target, "TERM_CLASS" if by_class else "TERM_COLOUR")
            total[part], pixels[part] = self._reduce(upload, target, term, candidates.weights[part])
        return Sums(total, pixels)

    def release(self) -> None:
        """Free the scratch buffers; the context must be current."""
        while self._scratch:
            self._scratch.popitem()[1].release()

    def _buffer(self, name: str, size: int) -> moderngl.Buffer:
        """A scratch buffer of at least `size` bytes; it only grows."""
        buffer = self._scratch.get(name)
        if buffer is None or buffer.size < size:
            if buffer is not None:
                buffer.release()
            buffer = self._scratch[name] = self._gl.ctx.buffer(reserve=size, dynamic=True)
        return buffer

    def _deform(
        self,
        upload: SceneUpload,
        candidates: Candidates,
        part: slice,
        camera: Camera,
        window: Window,
    ) -> moderngl.Buffer:
        """Clip coordinates of some candidates, (L, V, 4) float32 on the GPU."""
        states = _states(candidates, part)
        count, n_vertices = len(states), upload.n_vertices
        clips = self._buffer("clips", count * n_vertices * 16)
        stored = self._buffer("states", states.nbytes)
        stored.write(states)
        bound = clips, upload.buffer_of("mean"), upload.buffer_of("modes"), stored
        for binding, buffer in enumerate(bound):
            buffer.bind_to_storage_buffer(binding)
        program = self._programs.compute("deform")
        _set_camera(program, camera, window)
        set_uniform(program, "n_vertices", n_vertices)
        set_uniform(program, "n_modes", states.shape[1] - 12)
        program.run(-(-n_vertices // GROUP), count)
        self._gl.ctx.memory_barrier(moderngl.SHADER_STORAGE_BARRIER_BIT)
        return clips

    def _render(
        self, upload: SceneUpload, clips: moderngl.Buffer, target: targets.Target, term: str
    ) -> None:
        program = self._programs.drawing("pass", "pass", "LAYERED", term)

        def make() -> moderngl.VertexArray:
            carried = (
                (upload.by_class.label_buffer, "1i", "label")
                if term == "TERM_CLASS"
                else (upload.uv_buffer, "2f", "uv")
            )
            content = [(upload.source_buffer, "1i", "source"), carried]
            return self._gl.ctx.vertex_array(program, content, upload.index_buffer)

        target.clear(targets.FAR_AWAY)
        clips.bind_to_storage_buffer(CLIP)
        set_uniform(program, "n_vertices", upload.n_vertices)
        array = upload.vertex_array(f"instanced {term}", make)
        array.render(moderngl.TRIANGLES, instances=target.size[2])

    def _reduce(
        self,
        upload: SceneUpload,
        target: targets.Target,
        term: PixelTerm,
        weights: NDArray[np.float64],
    ) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
        """Sum the term over each layer on the GPU; eight bytes a layer come back."""
        width, height, layers = target.size
        by_class = isinstance(term, ClassMaps)
        defines = ("TERM_CLASS",) if by_class else ("TERM_COLOUR", *upload.texture_defines)
        program = self._programs.compute("reduce", *defines)
        target.colours[0].use(DRAWN)
        self._terms.get(term).texture.use(MAPS if by_class else TARGET)
        if not by_class:
            upload.use_texture(program, weights)
        sums = self._buffer("sums", 8 * layers)
        sums.bind_to_storage_buffer(0)
        set_uniform(program, "size", (width, height))
        program.run(layers)
        self._gl.ctx.memory_barrier(moderngl.BUFFER_UPDATE_BARRIER_BIT)
        read = np.frombuffer(sums.read(8 * layers), [("total", "<f4"), ("pixels", "<u4")])
        return read["total"], read["pixels"]


def _chunks(count: int, window: Window, formats: targets.Formats) -> Iterator[slice]:
    """Parts of a batch that fit the layer and memory limits."""
    width, height = window.drawn
    fitting = MAX_BYTES // (width * height * BYTES_PER_PIXEL[formats])
    step = max(1, min(MAX_LAYERS, fitting))
    for start in range(0, count, step):
        yield slice(start, min(start + step, count))


def _states(candidates: Candidates, part: slice) -> NDArray[np.float32]:
    """Rows of R|t (12 numbers) and weights, (L, 12 + P) float32."""
    weights = candidates.weights[part]
    out = np.empty((len(weights), 12 + weights.shape[1]), np.float32)
    pose = np.empty((len(weights), 3, 4), np.float32)
    pose[:, :, :3], pose[:, :, 3] = candidates.rotations[part], candidates.translations[part]
    out[:, :12], out[:, 12:] = pose.reshape(-1, 12), weights
    return out


def _set_camera(program: moderngl.ComputeShader, camera: Camera, window: Window) -> None:
    matrix = camera.clip_matrix(window).T  # GL wants columns
    set_uniform(program, "clip_matrix", tuple(matrix.ravel().tolist()))
    set_uniform(program, "k", tuple(camera.distortion.tolist()))
    set_uniform(program, "radius_limit", camera.radius_limit if camera.distorted else 0.0)
