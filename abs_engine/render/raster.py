"""The OpenGL renderer: a scene and a batch of candidates in, buffers or sums out."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Literal

import moderngl
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.buffers import Buffers, Outlines, Sums
from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import OpenGLError, ParameterError
from abs_engine.core.scene import Candidates, PixelTerm, Scene
from abs_engine.render import targets
from abs_engine.render.context import GLContext
from abs_engine.render.cpu import check_classes, check_term
from abs_engine.render.instanced import InstancedPath, can_layer
from abs_engine.render.programs import Programs
from abs_engine.render.thin import ThinPath
from abs_engine.render.upload import SceneUpload, TermUpload, WeakCache
from abs_engine.render.vertex import check_weights

VertexPath = Literal["auto", "thin", "instanced"]


class OpenGLRenderer:
    """Draws with OpenGL; fulfils `core.scene.Renderer`. Use it in a `with` statement.

    Scenes are uploaded once and freed after the scene object dies; so are pixel terms.

    Parameters
    ----------
    context : GLContext or str
        An open context (the renderer joins it and the caller still closes his), or the backend
        for `GLContext.open`.
    vertex_path : {"auto", "thin", "instanced"}
        "thin": the CPU deforms and projects, one draw for each candidate; the fastest way on a
        software rasteriser. "instanced": everything on the GPU, a batch in one draw. "auto" takes
        "instanced" on hardware.

    Raises
    ------
    OpenGLError
        If no context of the wanted kind can be made, or its driver lacks what the path needs.
    ParameterError
        If there is no such vertex path.
    """

    def __init__(self, context: GLContext | str = "auto", vertex_path: VertexPath = "auto") -> None:
        if vertex_path not in ("auto", "thin", "instanced"):
            raise ParameterError(
                f"there is no vertex path {vertex_path}", "choose one of auto, thin, instanced"
            )
        name = context.backend if isinstance(context, GLContext) else context
        self.gl = GLContext.open(name)
        chosen = "instanced" if self.gl.hardware and can_layer(self.gl) else "thin"
        self.vertex_path = chosen if vertex_path == "auto" else vertex_path
        self._programs = Programs(self.gl)
        self._pool = targets.TargetPool(self.gl)
        self._scenes = WeakCache[Scene, SceneUpload](lambda s: SceneUpload(self.gl, s))
        self._terms = WeakCache[PixelTerm, TermUpload](lambda t: TermUpload(self.gl, t))
        shared = self.gl, self._programs, self._pool, self._scenes
        self._path: ThinPath | InstancedPath = ThinPath(*shared)
        try:
            if self.vertex_path == "instanced":
                self._path = InstancedPath(*shared, self._terms)
        except OpenGLError:
            self.gl.close()
            raise
        self._open = True

    def __enter__(self) -> OpenGLRenderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def description(self) -> str:
        """Backend, GL renderer and version, and the vertex path."""
        return f"{self.gl.description}, {self.vertex_path} vertex path"

    def draw(
        self, scene: Scene, candidates: Candidates, camera: Camera, window: Window
    ) -> list[Buffers]:
        """Draw every candidate; see `Renderer.draw`.

        Raises
        ------
        ParameterError
            If the candidates have another number of weights than the scene has modes.
        OpenGLError
            If the renderer is closed, or belongs to another thread or process.
        """
        with self._drawing(scene, candidates):
            return self._path.draw(scene, candidates, camera, window)

    def outlines(
        self, scene: Scene, candidates: Candidates, camera: Camera, window: Window
    ) -> list[Outlines]:
        """Draw every candidate for what shows where classes meet; raises as `draw`."""
        with self._drawing(scene, candidates):
            return self._path.outlines(scene, candidates, camera, window)

    def measure(
        self, scene: Scene, candidates: Candidates, camera: Camera, window: Window, term: PixelTerm
    ) -> Sums:
        """Draw every candidate and sum `term`; see `Renderer.measure`.

        Raises
        ------
        ParameterError
            If candidates, scene, window and term do not fit together.
        OpenGLError
            If the renderer is closed, or belongs to another thread or process.
        """
        with self._drawing(scene, candidates):
            check_term(term, window)
            check_classes(scene, term)
            return self._path.measure(scene, candidates, camera, window, term)

    def picture(
        self, scene: Scene, candidates: Candidates, camera: Camera, window: Window, samples: int = 4
    ) -> list[NDArray[np.uint8]]:
        """Multisampled pictures to look at; nothing is measured on them.

        Parameters
        ----------
        samples : int
            Samples a pixel; the driver's limit is kept to.

        Returns
        -------
        list of (H, W, 3) uint8
            RGB, the background black.
        """
        with self._drawing(scene, candidates):
            canvas = targets.Canvas(self.gl, window.drawn, samples)
            try:
                return [
                    self._path.picture(scene, candidates, i, camera, window, canvas)
                    for i in range(len(candidates))
                ]
            finally:
                canvas.release()

    def close(self) -> None:
        """Release everything; the context too, if nobody else uses it."""
        if not self._open:
            return
        self._open = False
        with self.gl.current():
            for owner in (self._path, self._scenes, self._terms, self._pool, self._programs):
                owner.release()
        self.gl.close()

    @contextmanager
    def _drawing(self, scene: Scene, candidates: Candidates) -> Iterator[None]:
        """The scope of GL calls; a lost context or full memory must not pass for empty pictures."""
        check_weights(scene, candidates)
        if not self._open:
            raise OpenGLError("the renderer is closed", "open another one")
        with self.gl.current():
            ctx = self.gl.ctx
            try:
                ctx.enable_only(moderngl.DEPTH_TEST | (moderngl.CULL_FACE if scene.cull else 0))
                ctx.depth_func = "<"
                ctx.front_face = "cw"  # see Camera.clip_matrix
                ctx.cull_face = "back"
                yield
            except moderngl.Error as error:
                _ = ctx.error  # which would be that of the next drawing
                raise _failed(" ".join(str(error).split())) from error
            found = ctx.error
            if found != "GL_NO_ERROR":
                raise _failed(found)


def _failed(said: str) -> OpenGLError:
    return OpenGLError(
        f"OpenGL failed ({said})", "free the GPU, draw smaller windows, or use --renderer cpu"
    )
