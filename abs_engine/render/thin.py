"""The thin vertex path: the CPU deforms and projects, OpenGL decides what is seen."""

from __future__ import annotations

from collections.abc import Iterator

import moderngl
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.buffers import Buffers, Outlines, Sums
from abs_engine.core.camera import Camera, Window
from abs_engine.core.scene import Candidates, ClassMaps, PixelTerm, Scene
from abs_engine.render import facets, targets
from abs_engine.render.context import GLContext
from abs_engine.render.layout import settle, submit, worth_drawing
from abs_engine.render.pixel_kernels import outlines
from abs_engine.render.pixelsum import colour_error, sum_class_maps
from abs_engine.render.programs import Programs
from abs_engine.render.upload import Labelled, SceneUpload, WeakCache
from abs_engine.render.vertex import clip_positions


class ThinPath:
    """One draw for each candidate; made for software rasterisers."""

    def __init__(
        self,
        gl: GLContext,
        programs: Programs,
        pool: targets.TargetPool,
        scenes: WeakCache[Scene, SceneUpload],
    ) -> None:
        self._gl, self._programs, self._pool, self._scenes = gl, programs, pool, scenes

    def draw(
        self, scene: Scene, candidates: Candidates, camera: Camera, window: Window
    ) -> list[Buffers]:
        """Buffers of every candidate."""
        upload = self._scenes.get(scene)
        target = self._pool.get((*window.drawn, 1), targets.ALL_BUFFERS)
        given = self._gl, self._programs, upload, upload.vertex_buffer, target
        written = _written(upload, scene, candidates, camera, window)
        drawn = (
            facets.draw_buffers(*given, candidates.weights[i : i + 1], kept)
            for i, kept in enumerate(written)
        )
        return [buffers for (buffers,) in drawn]

    def outlines(
        self, scene: Scene, candidates: Candidates, camera: Camera, window: Window
    ) -> list[Outlines]:
        """Borders of every candidate: OpenGL draws facets' numbers, the CPU computes the rest."""
        upload = self._scenes.get(scene)
        target = self._pool.get((*window.drawn, 1), targets.LABEL)
        clip, found = camera.clip_matrix(window), []
        for i in range(len(candidates)):
            positions = clip_positions(scene, candidates, i, camera, clip)
            self._render(upload, upload.by_facet, scene, positions, camera, target)
            facet = target.read()[0, ..., 0].copy()
            shown, depth = np.empty_like(facet), np.empty(facet.shape, np.float32)
            bary = np.empty((*facet.shape, 3), np.float32)
            outlines(positions, scene.faces, facet, scene.facet_class, shown, depth, bary)
            found.append(Outlines(facet, shown, depth, bary))
        return found

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
        clip = camera.clip_matrix(window)
        upload.vertex_buffer.write(clip_positions(scene, candidates, index, camera, clip))
        weights = candidates.weights[index : index + 1]
        given = self._gl, self._programs, upload, upload.vertex_buffer, canvas, weights
        return facets.draw_picture(*given)

    def measure(
        self, scene: Scene, candidates: Candidates, camera: Camera, window: Window, term: PixelTerm
    ) -> Sums:
        """Sums of every candidate."""
        upload = self._scenes.get(scene)
        by_class = isinstance(term, ClassMaps)
        target = self._pool.get(
            (*window.drawn, 1), targets.LABEL if by_class else targets.TEXTURE_UV
        )
        clip = camera.clip_matrix(window)
        total = np.empty(len(candidates), np.float64)
        pixels = np.empty(len(candidates), np.int64)
        for i in range(len(candidates)):
            positions = clip_positions(scene, candidates, i, camera, clip)
            self._render(
                upload, upload.by_class, scene, positions, camera, target, coloured=not by_class
            )
            drawn = target.read()[0]
            if isinstance(term, ClassMaps):
                total[i], pixels[i] = sum_class_maps(drawn[..., 0], term.maps)
            else:
                total[i], pixels[i] = colour_error(drawn, scene, term, candidates.weights[i])
        return Sums(total, pixels)

    def release(self) -> None:
        """Nothing of its own to free."""

    def _render(
        self,
        upload: SceneUpload,
        labelled: Labelled,
        scene: Scene,
        positions: NDArray[np.float32],
        camera: Camera,
        target: targets.Target,
        *,
        coloured: bool = False,
    ) -> None:
        """Draw the facets' labels or, for colours, their texture coordinates."""
        width, height, _ = target.size
        layout, spread, kept = labelled.layout, labelled.positions, labelled.kept
        size = float(width), float(height)
        count = submit(
            positions, layout.source, layout.faces, scene.cull, size, spread, kept, camera.near
        )
        if not coloured:
            settle(spread, size, camera.near, camera.far)
        labelled.vertex_buffer.write(spread)
        target.clear(targets.FAR_AWAY)
        if count:
            labelled.kept_buffer.write(kept[:count])
            array = self._array(upload, labelled, coloured)
            array.render(moderngl.TRIANGLES, vertices=3 * count)

    def _array(
        self, upload: SceneUpload, labelled: Labelled, coloured: bool
    ) -> moderngl.VertexArray:
        def make() -> moderngl.VertexArray:
            carried = (
                (upload.uv_buffer, "2f", "uv")
                if coloured
                else (labelled.label_buffer, "1i", "label")
            )
            return self._gl.ctx.vertex_array(
                self._programs.drawing("pass", "pass", "TERM_COLOUR" if coloured else "TERM_CLASS"),
                [(labelled.vertex_buffer, "4f", "clip"), carried],
                labelled.kept_buffer,
            )

        return upload.vertex_array(f"thin {labelled.name} {coloured}", make)


def _written(
    upload: SceneUpload, scene: Scene, candidates: Candidates, camera: Camera, window: Window
) -> Iterator[int]:
    """Write the vertices of each candidate; yields how many of its facets are worth drawing."""
    matrix = camera.clip_matrix(window)
    size = float(window.drawn[0]), float(window.drawn[1])
    for index in range(len(candidates)):
        clip = clip_positions(scene, candidates, index, camera, matrix)
        upload.vertex_buffer.write(clip)
        yield worth_drawing(clip, scene.faces, scene.cull, size, camera.near, upload.kept_facets)
