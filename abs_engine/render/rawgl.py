"""The few OpenGL calls that moderngl does not offer, loaded from the same context."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from ctypes import c_float, c_int, c_uint, c_void_p
from functools import lru_cache
from typing import Any

_TEXTURE_2D_ARRAY, _DEPTH_COMPONENT32F = 0x8C1A, 0x8CAC
_FRAMEBUFFER, _DEPTH_ATTACHMENT = 0x8D40, 0x8D00
_COLOR, _DEPTH = 0x1800, 0x1801

_SIGNATURES: dict[str, tuple[Any, ...]] = {
    "glGenTextures": (c_int, c_void_p),
    "glDeleteTextures": (c_int, c_void_p),
    "glBindTexture": (c_uint, c_uint),
    "glTexStorage3D": (c_uint, c_int, c_uint, c_int, c_int, c_int),
    "glBindFramebuffer": (c_uint, c_uint),
    "glFramebufferTexture": (c_uint, c_uint, c_uint, c_int),
    "glClearBufferfv": (c_uint, c_int, c_void_p),
    "glClearBufferiv": (c_uint, c_int, c_void_p),
}

_NO_ID = (c_int * 4)()


@lru_cache(maxsize=8)
def _four(value: float) -> Any:
    return (c_float * 4)(*[value] * 4)


class RawGL:
    """Depth array textures and typed clears; `load` gives the address of a GL function by name."""

    def __init__(self, load: Callable[[str], int]) -> None:
        self._call = {
            name: ctypes.CFUNCTYPE(None, *types)(load(name)) for name, types in _SIGNATURES.items()
        }

    def depth_array(self, width: int, height: int, layers: int) -> int:
        """A new 32-bit float depth texture of `layers` layers; the caller deletes it."""
        name = c_uint(0)
        self._call["glGenTextures"](1, ctypes.byref(name))
        self._call["glBindTexture"](_TEXTURE_2D_ARRAY, name)
        self._call["glTexStorage3D"](
            _TEXTURE_2D_ARRAY, 1, _DEPTH_COMPONENT32F, width, height, layers
        )
        self._call["glBindTexture"](_TEXTURE_2D_ARRAY, 0)
        return int(name.value)

    def attach_depth(self, framebuffer: int, texture: int) -> None:
        """Attach all layers of a depth array; the framebuffer stays bound."""
        self._call["glBindFramebuffer"](_FRAMEBUFFER, framebuffer)
        self._call["glFramebufferTexture"](_FRAMEBUFFER, _DEPTH_ATTACHMENT, texture, 0)

    def delete_texture(self, texture: int) -> None:
        """Delete a texture made by `depth_array`."""
        self._call["glDeleteTextures"](1, ctypes.byref(c_uint(texture)))

    def clear_float(self, attachment: int, value: float) -> None:
        """Clear a float attachment of the bound framebuffer, all layers."""
        self._call["glClearBufferfv"](_COLOR, attachment, _four(value))

    def clear_int(self, attachment: int) -> None:
        """Clear an integer attachment of the bound framebuffer to 0, all layers.

        `glClear` leaves integer targets undefined.
        """
        self._call["glClearBufferiv"](_COLOR, attachment, _NO_ID)

    def clear_depth(self) -> None:
        """Clear the depth of the bound framebuffer to the far plane, all layers."""
        self._call["glClearBufferfv"](_DEPTH, 0, _four(1.0))
