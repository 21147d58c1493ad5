"""Live objects of an OpenGL context, to find what is left behind."""

from __future__ import annotations

from ctypes import CFUNCTYPE, c_ubyte, c_uint

from abs_engine.render.context import GLContext

_KINDS = ("Texture", "Buffer", "Framebuffer", "Renderbuffer", "VertexArray", "Program")
_MOST = 4096  # names that are asked for


def live_objects(gl: GLContext) -> dict[str, int]:
    """How many of each kind there are."""
    with gl.current():
        asks = {k: CFUNCTYPE(c_ubyte, c_uint)(gl.native.load(f"glIs{k}")) for k in _KINDS}
        return {k: sum(bool(ask(name)) for name in range(1, _MOST)) for k, ask in asks.items()}
