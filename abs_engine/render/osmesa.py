"""OpenGL contexts through OSMesa, the last resort (Mesa 25.1 removed it)."""

from __future__ import annotations

import ctypes
from ctypes import c_char_p, c_int, c_uint, c_void_p

from abs_engine.core.errors import OpenGLError

PACKAGES_OSMESA = "apt-get install libosmesa6"

_FORMAT, _RGBA, _PROFILE, _CORE = 0x22, 0x1908, 0x33, 0x34
_MAJOR, _MINOR, _DEPTH_BITS, _UNSIGNED_BYTE = 0x36, 0x37, 0x30, 0x1401


class OSMesaContext:
    """An OSMesaContext that moderngl takes; `with` makes it current and restores what was before.

    OSMesa needs a colour buffer of its own to be current; it is 4x4 and never drawn to.
    """

    def __init__(self, library: ctypes.CDLL, context: int) -> None:
        self._library, self._context = library, context
        self._pixels = (ctypes.c_ubyte * (4 * 4 * 4))()

    def load(self, name: str) -> int:
        """Address of a GL function, 0 where there is none."""
        return int(self._library.OSMesaGetProcAddress(name.encode()) or 0)

    def make_current(self) -> None:
        """Make the context current on this thread; `OpenGLError` if the library refuses."""
        made = self._library.OSMesaMakeCurrent(self._context, self._pixels, _UNSIGNED_BYTE, 4, 4)
        if not made:
            raise OpenGLError("OSMesa refuses to be made current", PACKAGES_OSMESA)

    def __enter__(self) -> OSMesaContext:
        # Another OSMesa context cannot be restored, for its buffer cannot be asked for; OSMesa
        # keeps apart from EGL, so there is nothing else to restore.
        if self._library.OSMesaGetCurrentContext() != self._context:
            self.make_current()
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def release(self) -> None:
        """Destroy the context."""
        if self._context:
            self._library.OSMesaDestroyContext(self._context)
            self._context = 0


def open_osmesa() -> OSMesaContext:
    """An OSMesa context, OpenGL 4.3 core or later, current on this thread.

    Raises `OpenGLError` if the library is missing or gives no such context.
    """
    library = _load()
    for minor in (5, 3):
        attributes = (_FORMAT, _RGBA, _DEPTH_BITS, 0, _PROFILE, _CORE, _MAJOR, 4, _MINOR, minor, 0)
        values = (c_int * len(attributes))(*attributes)
        context = library.OSMesaCreateContextAttribs(values, None)
        if context:
            opened = OSMesaContext(library, context)
            opened.make_current()
            return opened
    raise OpenGLError("OSMesa gives no OpenGL 4.3 core", PACKAGES_OSMESA)


def _load() -> ctypes.CDLL:
    for name in ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"):
        try:
            library = ctypes.CDLL(name)
        except OSError:
            continue
        library.OSMesaCreateContextAttribs.restype = c_void_p
        library.OSMesaCreateContextAttribs.argtypes = [c_void_p, c_void_p]
        library.OSMesaMakeCurrent.argtypes = [c_void_p, c_void_p, c_uint, c_int, c_int]
        library.OSMesaGetProcAddress.restype = c_void_p
        library.OSMesaGetProcAddress.argtypes = [c_char_p]
        library.OSMesaGetCurrentContext.restype = c_void_p
        library.OSMesaDestroyContext.argtypes = [c_void_p]
        return library
    raise OpenGLError("libOSMesa cannot be loaded", PACKAGES_OSMESA)
