"""Drawing all buffers, or a picture, of clip coordinates that lie in a storage buffer."""

from __future__ import annotations

import moderngl
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.buffers import Buffers
from abs_engine.render.context import GLContext
from abs_engine.render.programs import CLIP, KEPT, Programs, set_uniform
from abs_engine.render.targets import Canvas, Target
from abs_engine.render.upload import SceneUpload


def draw_buffers(
    gl: GLContext,
    programs: Programs,
    upload: SceneUpload,
    clips: moderngl.Buffer,
    target: Target,
    weights: NDArray[np.float64],
    kept: int | None = None,
) -> list[Buffers]:
    """Draw one candidate into each layer of a target of `ALL_BUFFERS`, and read them.

    `clips` are (L, V, 4) float32 clip coordinates; `weights` (L, P) are of the modes, for a texture
    that depends on them. Of one candidate, `kept` of `upload.kept_facets` are drawn; by default
    all.
    """
    layers = target.size[2]
    defines = ("LAYERED", *upload.texture_defines) if layers > 1 else upload.texture_defines
    target.clear()
    _draw(gl, programs, ("buffers", *defines), upload, clips, weights, kept)
    colour_depth, two, ids = (target.read(i) for i in range(3))
    return [_buffers(colour_depth[i], two[i], ids[i]) for i in range(layers)]


def draw_picture(
    gl: GLContext,
    programs: Programs,
    upload: SceneUpload,
    clips: moderngl.Buffer,
    canvas: Canvas,
    weights: NDArray[np.float64],
) -> NDArray[np.uint8]:
    """Draw the first candidate of `clips` with many samples a pixel."""
    canvas.clear()
    _draw(gl, programs, ("picture", *upload.texture_defines), upload, clips, weights)
    return canvas.read()


def _draw(
    gl: GLContext,
    programs: Programs,
    fragment: tuple[str, ...],
    upload: SceneUpload,
    clips: moderngl.Buffer,
    weights: NDArray[np.float64],
    kept: int | None = None,
) -> None:
    """Draw facets with a fragment shader and its definitions."""
    name, *defines = fragment
    if kept == 0:
        return
    if kept is not None:
        defines.append("KEPT")
        upload.kept_facets_buffer.write(upload.kept_facets[:kept])
        upload.kept_facets_buffer.bind_to_storage_buffer(KEPT)
    program = programs.drawing("facets", name, *defines)
    clips.bind_to_storage_buffer(CLIP)
    stored = upload.buffer_of("faces"), upload.uv_buffer, upload.buffer_of("facet_class")
    for binding, buffer in enumerate(stored, start=1):
        buffer.bind_to_storage_buffer(binding)
    upload.use_texture(program, weights)
    set_uniform(program, "n_vertices", upload.n_vertices)
    array = upload.vertex_array(f"facets {program.glo}", lambda: gl.ctx.vertex_array(program, []))
    count = upload.n_facets if kept is None else kept
    array.render(moderngl.TRIANGLES, vertices=3 * count, instances=len(weights))


def _buffers(
    colour_depth: NDArray[np.float32], two: NDArray[np.float32], ids: NDArray[np.int32]
) -> Buffers:
    bary = np.empty((*two.shape[:2], 3), np.float32)
    bary[..., :2] = two
    bary[..., 2] = np.where(ids[..., 0] > 0, 1 - two[..., 0] - two[..., 1], 0)
    return Buffers(
        rgb=colour_depth[..., :3].copy(),
        facet_id=ids[..., 0].copy(),
        class_id=ids[..., 1].copy(),
        depth=colour_depth[..., 3].copy(),
        barycentrics=bary,
    )
