"""The renderer's programs, compiled when they are first needed."""

from __future__ import annotations

from typing import Any

import moderngl

from abs_engine.render import shaders
from abs_engine.render.context import GLContext

SKIN, TARGET, MAPS, DRAWN, SKIN_MODES = range(5)
"""Texture units."""

CLIP = 0
"""Storage binding of clip coordinates, as in the shaders."""

TEXTURE_WEIGHTS = 4
"""Storage binding of the weights of a texture's modes, as in texture.glsl."""

KEPT = 5
"""Storage binding of the numbers of facets that are drawn, as in facets.vert."""


class Programs:
    """Compiled shaders by name and defines."""

    def __init__(self, gl: GLContext) -> None:
        self._ctx = gl.ctx
        self._made: dict[tuple[str, ...], Any] = {}

    def drawing(self, vertex: str, fragment: str, *defines: str) -> moderngl.Program:
        """The program of `vertex`.vert and `fragment`.frag."""
        key = vertex, fragment, *defines
        if key not in self._made:
            made = shaders.program(
                self._ctx,
                shaders.load(f"{vertex}.vert", defines),
                shaders.load(f"{fragment}.frag", defines),
            )
            _bind_textures(made, skin=SKIN, skin_modes=SKIN_MODES)
            self._made[key] = made
        program: moderngl.Program = self._made[key]
        return program

    def compute(self, name: str, *defines: str) -> moderngl.ComputeShader:
        """The program of `name`.comp."""
        key = name, *defines
        if key not in self._made:
            made = shaders.compute(self._ctx, shaders.load(f"{name}.comp", defines))
            units = {"skin": SKIN, "skin_modes": SKIN_MODES, "target": TARGET}
            _bind_textures(made, **units, maps=MAPS, drawn=DRAWN)
            self._made[key] = made
        program: moderngl.ComputeShader = self._made[key]
        return program

    def release(self) -> None:
        """Free all; the context must be current."""
        while self._made:
            self._made.popitem()[1].release()


def set_uniform(program: Any, name: str, value: Any) -> None:
    """Set a uniform; one that the compiler has optimised away is passed over."""
    uniform = program.get(name, None)
    if uniform is not None:
        uniform.value = value


def _bind_textures(program: Any, **units: int) -> None:
    for name, unit in units.items():
        set_uniform(program, name, unit)
