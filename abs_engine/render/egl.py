"""OpenGL contexts through EGL without a screen: a GPU's device, or Mesa's surfaceless platform.

glcontext's EGL backend always opens the n-th EGL device and cannot say whether that is a GPU, nor
open the surfaceless platform; so the calls are made here. Objects of `EglContext` are what
`moderngl.create_context(context=...)` expects: `load`, `__enter__`, `__exit__`, `release`.
"""

from __future__ import annotations

import ctypes
from ctypes import POINTER, c_char_p, c_int, c_long, c_void_p
from typing import Any

from abs_engine.core.errors import OpenGLError

PACKAGES_EGL = "apt-get install libegl1 libgl1-mesa-dri"
PACKAGES_DRIVER = "apt-get install libgl1-mesa-dri"

_SURFACELESS, _DEVICE = 0x31DD, 0x313F
_OPENGL_API, _EXTENSIONS, _NONE = 0x30A2, 0x3055, 0x3038
_BAD_ACCESS = 0x3002
_SURFACE_TYPE, _PBUFFER_BIT, _RENDERABLE_TYPE, _OPENGL_BIT = 0x3033, 0x0001, 0x3040, 0x0008
_MAJOR, _MINOR, _PROFILE, _CORE = 0x3098, 0x30FB, 0x30FD, 0x0001
_SOFTWARE_DEVICE = b"EGL_MESA_device_software"
VERSIONS = ((4, 5), (4, 3))  # 4.3: compute shaders and storage buffers


class EglContext:
    """A current-able EGL context; `with` makes it current and restores what was current before.

    `display` is an EGLDisplay, `context` an EGLContext.
    """

    def __init__(self, egl: ctypes.CDLL, display: int, context: int) -> None:
        self._egl, self._display, self._context = egl, display, context
        self._current = egl.eglGetCurrentContext
        self._before: list[tuple[int, int, int, int] | None] = []

    def load(self, name: str) -> int:
        """Address of a GL function, 0 where there is none."""
        return int(self._egl.eglGetProcAddress(name.encode()) or 0)

    def make_current(self) -> None:
        """Make the context current on this thread.

        Raises `OpenGLError` if another thread holds it, or the driver has lost it.
        """
        egl = self._egl
        egl.eglBindAPI(_OPENGL_API)
        if not egl.eglMakeCurrent(self._display, None, None, self._context):
            code = egl.eglGetError()
            if code == _BAD_ACCESS:
                problem = "the OpenGL context is current in another thread"
                raise OpenGLError(problem, "use it from the thread that opened it only")
            raise OpenGLError(
                f"the driver has lost the OpenGL context (EGL error {code:#x})",
                "give the same command again, or choose --renderer cpu",
            )

    def __enter__(self) -> EglContext:
        if self._current() == self._context:
            self._before.append(None)
            return self
        egl = self._egl
        before = egl.eglGetCurrentContext() or 0
        display = egl.eglGetCurrentDisplay() or self._display
        draw, read = (egl.eglGetCurrentSurface(side) or 0 for side in (0x3059, 0x305A))
        self.make_current()
        self._before.append((display, draw, read, before))
        return self

    def __exit__(self, *_: object) -> None:
        before = self._before.pop()
        if before is not None:
            self._egl.eglMakeCurrent(*before)

    def release(self) -> None:
        """Destroy the context. The display stays: others in this process may share it."""
        if self._context:
            if self._current() == self._context:
                self._egl.eglMakeCurrent(self._display, None, None, None)
            self._egl.eglDestroyContext(self._display, self._context)
            self._context = 0


def load_egl() -> ctypes.CDLL:
    """The EGL library with its signatures declared; `OpenGLError` if it cannot be loaded."""
    try:
        egl = ctypes.CDLL("libEGL.so.1")
    except OSError as error:
        raise OpenGLError(f"libEGL cannot be loaded ({error})", PACKAGES_EGL) from error
    for name, result, *arguments in _SIGNATURES:
        function = getattr(egl, name)
        function.restype, function.argtypes = result, arguments
    return egl


_SIGNATURES: tuple[tuple[Any, ...], ...] = (
    ("eglGetProcAddress", c_void_p, c_char_p),
    ("eglGetError", c_int),
    ("eglBindAPI", c_int, c_int),
    ("eglInitialize", c_int, c_void_p, c_void_p, c_void_p),
    ("eglChooseConfig", c_int, c_void_p, c_void_p, c_void_p, c_int, c_void_p),
    ("eglCreateContext", c_void_p, c_void_p, c_void_p, c_void_p, c_void_p),
    ("eglDestroyContext", c_int, c_void_p, c_void_p),
    ("eglMakeCurrent", c_int, c_void_p, c_void_p, c_void_p, c_void_p),
    ("eglGetCurrentContext", c_void_p),
    ("eglGetCurrentDisplay", c_void_p),
    ("eglGetCurrentSurface", c_void_p, c_int),
)


def open_surfaceless() -> EglContext:
    """A context on Mesa's surfaceless platform (llvmpipe where there is no GPU).

    Raises `OpenGLError` if EGL or a Mesa driver is missing.
    """
    egl = load_egl()
    return _open_display(egl, _platform_display(egl, _SURFACELESS, None))


def hardware_devices() -> list[int]:
    """EGLDeviceEXT handles of the devices that do not declare themselves software.

    Raises `OpenGLError` if EGL is missing or cannot list devices.
    """
    egl = load_egl()
    query = _extension(egl, "eglQueryDevicesEXT", c_int, c_int, c_void_p, c_void_p)
    describe = _extension(egl, "eglQueryDeviceStringEXT", c_char_p, c_void_p, c_int)
    count = c_int(0)
    if not query(0, None, ctypes.byref(count)):
        raise OpenGLError("EGL cannot list devices", "install the GPU's driver")
    handles = (c_void_p * max(1, count.value))()
    query(count.value, ctypes.cast(handles, c_void_p), ctypes.byref(count))
    found = [handles[i] or 0 for i in range(count.value)]
    return [h for h in found if _SOFTWARE_DEVICE not in (describe(h, _EXTENSIONS) or b"")]


def open_device(device: int) -> EglContext:
    """A context on one EGL device, a handle of `hardware_devices`.

    Raises `OpenGLError` if the device gives no desktop OpenGL.
    """
    egl = load_egl()
    return _open_display(egl, _platform_display(egl, _DEVICE, device))


def _extension(egl: ctypes.CDLL, name: str, result: Any, *arguments: Any) -> Any:
    address = egl.eglGetProcAddress(name.encode())
    if not address:
        raise OpenGLError(f"this EGL has no {name}", PACKAGES_EGL)
    return ctypes.CFUNCTYPE(result, *arguments)(address)


def _platform_display(egl: ctypes.CDLL, platform: int, native: int | None) -> int:
    get = _extension(egl, "eglGetPlatformDisplayEXT", c_void_p, c_int, c_void_p, POINTER(c_long))
    display = get(platform, native, None)
    if not display:
        raise OpenGLError("EGL loads, but no driver offers this platform", PACKAGES_DRIVER)
    if not egl.eglInitialize(display, None, None):
        code = egl.eglGetError()
        raise OpenGLError(f"EGL loads, but no driver starts (error {code:#x})", PACKAGES_DRIVER)
    return int(display)


def _open_display(egl: ctypes.CDLL, display: int) -> EglContext:
    egl.eglBindAPI(_OPENGL_API)
    wanted = (c_int * 5)(_SURFACE_TYPE, _PBUFFER_BIT, _RENDERABLE_TYPE, _OPENGL_BIT, _NONE)
    config, found = c_void_p(), c_int(0)
    egl.eglChooseConfig(display, wanted, ctypes.byref(config), 1, ctypes.byref(found))
    chosen = config if found.value else None  # none: EGL_NO_CONFIG_KHR
    for major, minor in VERSIONS:
        asked = (c_int * 7)(_MAJOR, major, _MINOR, minor, _PROFILE, _CORE, _NONE)
        context = egl.eglCreateContext(display, chosen, None, asked)
        if context:
            opened = EglContext(egl, display, context)
            opened.make_current()
            return opened
    raise OpenGLError(
        f"the EGL driver gives no OpenGL 4.3 core (error {egl.eglGetError():#x})", PACKAGES_DRIVER
    )
