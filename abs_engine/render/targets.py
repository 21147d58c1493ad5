"""Pooled framebuffers with layered attachments; integer ids go to integer targets."""

from __future__ import annotations

from collections import OrderedDict
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from abs_engine.render.context import GLContext

Formats = tuple[tuple[int, str], ...]

LABEL: Formats = ((1, "i4"),)
TEXTURE_UV: Formats = ((2, "f4"),)
ALL_BUFFERS: Formats = ((4, "f4"), (2, "f4"), (2, "i4"))  # colour and depth, barycentrics, ids
FAR_AWAY = -1e30
"""Where texture coordinates were not drawn."""

POOL_SIZE = 6


class Target:
    """A framebuffer of array textures, one layer for each candidate.

    `size` is width, height and layers; `formats` are components and moderngl dtype of each colour
    attachment.
    """

    def __init__(self, gl: GLContext, size: tuple[int, int, int], formats: Formats) -> None:
        self._gl, self.size, self.formats = gl, size, formats
        self.colours = [gl.ctx.texture_array(size, parts, dtype=kind) for parts, kind in formats]
        for texture in self.colours:
            texture.filter = moderngl.NEAREST, moderngl.NEAREST
        self.fbo = gl.ctx.framebuffer(self.colours)
        self.depth = gl.raw.depth_array(*size)
        gl.raw.attach_depth(self.fbo.glo, self.depth)
        self.fbo.depth_mask = True  # moderngl saw no depth attachment and would write none
        width, height, layers = size
        self._read = [
            np.empty((layers, height, width, parts), np.int32 if kind == "i4" else np.float32)
            for parts, kind in formats
        ]

    def clear(self, background: float = 0.0) -> None:
        """Bind and clear all layers: floats to `background`, ids to 0, depth to the far plane."""
        self.fbo.use()
        raw = self._gl.raw
        for i, (_, kind) in enumerate(self.formats):
            if kind == "i4":
                raw.clear_int(i)
            else:
                raw.clear_float(i, background)
        raw.clear_depth()

    def read(self, attachment: int = 0) -> NDArray[Any]:
        """An attachment's pixels, (L, H, W, C), valid until the next read of the same."""
        # glGetTexImage and not glReadPixels, which Mesa converts pixel by pixel from R32I.
        out = self._read[attachment]
        self.colours[attachment].read_into(out)
        return out

    def release(self) -> None:
        """Free the framebuffer and its textures."""
        _unbind(self._gl)
        self.fbo.release()
        for texture in self.colours:
            texture.release()
        self._gl.raw.delete_texture(self.depth)


class TargetPool:
    """The last few targets that were used, by size and formats."""

    def __init__(self, gl: GLContext) -> None:
        self._gl = gl
        self._targets: OrderedDict[tuple[tuple[int, int, int], Formats], Target] = OrderedDict()

    def get(self, size: tuple[int, int, int], formats: Formats) -> Target:
        """The target of this width, height, layers and formats; the context must be current."""
        key = size, formats
        target = self._targets.get(key)
        if target is None:
            while len(self._targets) >= POOL_SIZE:
                self._targets.popitem(last=False)[1].release()
            target = self._targets[key] = Target(self._gl, size, formats)
        self._targets.move_to_end(key)
        return target

    def release(self) -> None:
        """Free all; the context must be current."""
        while self._targets:
            self._targets.popitem()[1].release()


class Canvas:
    """A multisampled framebuffer and the plain one it is resolved to, for one picture at a time.

    `size` is width and height; there are so many `samples` a pixel.
    """

    def __init__(self, gl: GLContext, size: tuple[int, int], samples: int) -> None:
        ctx, self._gl = gl.ctx, gl
        many = max(0, min(samples, ctx.max_samples))
        self.size = size
        self._parts: list[Any] = [
            ctx.renderbuffer(size, 4, samples=many),
            ctx.depth_renderbuffer(size, samples=many),
            ctx.renderbuffer(size, 4),
        ]
        self._fine = ctx.framebuffer([self._parts[0]], self._parts[1])
        self._plain = ctx.framebuffer([self._parts[2]])

    def clear(self) -> None:
        """Bind and clear to black."""
        self._fine.use()
        self._fine.clear()

    def read(self) -> NDArray[np.uint8]:
        """The picture, (H, W, 3) uint8 RGB."""
        self._gl.ctx.copy_framebuffer(self._plain, self._fine)
        width, height = self.size
        pixels = np.frombuffer(self._plain.read(components=3), np.uint8)
        return pixels.reshape(height, width, 3).copy()

    def release(self) -> None:
        """Free everything."""
        _unbind(self._gl)
        for item in (self._fine, self._plain, *self._parts):
            item.release()


def _unbind(gl: GLContext) -> None:
    """Bind no framebuffer of ours: moderngl would bind a deleted one again later."""
    gl.ctx.screen.use()
