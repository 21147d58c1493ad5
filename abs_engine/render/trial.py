"""A plugin's renderer tried on a triangle before anything is compared with what it draws."""

from __future__ import annotations

import numpy as np

from abs_engine.core.buffers import Buffers
from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import PluginError
from abs_engine.core.foreign import blamed, own
from abs_engine.core.scene import Candidates, Renderer, Scene

_CAMERA, _WINDOW = Camera.ideal((64, 48)), Window(12.0, 8.0, 30.0, 20.0, 1.5)
_DISTANCE = 500.0  # mm, of a triangle that is wider than the window
_SIDE, _CLASS = 400.0, 3
_KINDS = {
    "rgb": ("f", (3,)), "facet_id": ("iu", ()), "class_id": ("iu", ()), "depth": ("f", ()),
    "barycentrics": ("f", (3,)),
}  # fmt: skip
"""Kinds of numbers in each buffer, and how many for a pixel."""


def check_renderer(name: str, renderer: Renderer) -> None:
    """Raise `PluginError` if a renderer, not the engine's own, draws no buffers of the window."""
    if own(type(renderer)):
        return
    lacks = [part for part in ("description", "draw", "close") if not hasattr(renderer, part)]
    if lacks:
        raise PluginError(f"the renderer '{name}' has no '{lacks[0]}'", "add it to its class")
    several = Candidates(
        np.zeros((2, 0)), np.tile(np.eye(3), (2, 1, 1)), np.tile([0.0, 0.0, _DISTANCE], (2, 1))
    )
    with blamed(f"the renderer '{name}'"):
        drawn = renderer.draw(_triangle(), several, _CAMERA, _WINDOW)
    wrong = _wrong(drawn, len(several))
    if wrong:
        raise PluginError(
            f"the renderer '{name}' draws {wrong}",
            "let draw return Buffers of the window's drawn size for each candidate: rgb, depth and "
            "barycentrics as floats, ids as integers",
        )


def _triangle() -> Scene:
    """A grey triangle that covers the window from either side."""
    corners = np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], np.float32)
    none, facet = np.zeros((0, 3, 3), np.float32), np.array([[0, 1, 2]], np.int32)
    middle, grey = np.full((3, 2), 0.5, np.float32), np.full((4, 4, 3), 128, np.uint8)
    side = np.float32(_SIDE)
    kind = np.full(1, _CLASS, np.int32)
    return Scene(side * corners, none, facet, middle, kind, grey, cull=False)


def _wrong(drawn: object, count: int) -> str:
    """Fault of the drawings of some candidates; empty where there is none."""
    if not isinstance(drawn, list | tuple):
        return f"an object of type {type(drawn).__name__}, not a list"
    if len(drawn) != count:
        return f"{len(drawn)} of {count} candidates"
    other = [one for one in drawn if not isinstance(one, Buffers)]
    if other:
        return f"an object of type {type(other[0]).__name__}, not Buffers"
    faults = (_fault(name, getattr(one, name)) for one in drawn for name in _KINDS)
    found = next((fault for fault in faults if fault), "")
    if found:
        return found
    if not all((one.facet_id == 1).any() for one in drawn):
        return "nothing of a triangle that fills the window"
    if any((one.class_id[one.facet_id == 1] != _CLASS).any() for one in drawn):
        return "class_id of another class than the triangle's"
    return ""


def _fault(name: str, buffer: object) -> str:
    """Fault of one buffer; empty where there is none."""
    kinds, each = _KINDS[name]
    width, height = _WINDOW.drawn
    if not isinstance(buffer, np.ndarray):
        return f"an object of type {type(buffer).__name__} for {name}"
    if buffer.shape != (height, width, *each):
        return f"{name} of shape {buffer.shape}, not {(height, width, *each)}"
    if buffer.dtype.kind not in kinds:
        return f"{name} as {buffer.dtype}"
    return "" if np.isfinite(buffer).all() else f"{name} that is not finite"
