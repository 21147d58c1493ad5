"""Ownership of the OpenGL context.

Rules. A process has one context at most: opening a second time gives the same one, and the last
user's `close` destroys it. It belongs to the thread that opened it. A child made by `fork` must
not use it; open one there. Nothing happens at import, and no environment variable picks the
platform: the caller names a backend, or `auto` tries them in the order of `BACKENDS`.

`ABS_ENGINE_HIDE_GL` (a comma list of backends, or `all`) makes backends look absent. It is an aid
for tests and for trying the CPU rasteriser's fallback.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import moderngl

from abs_engine.core.errors import OpenGLError
from abs_engine.render import egl, osmesa
from abs_engine.render.rawgl import RawGL

BACKENDS = ("egl-device", "egl-surfaceless", "osmesa")
HIDE_VARIABLE = "ABS_ENGINE_HIDE_GL"
SOFTWARE = ("llvmpipe", "softpipe", "swrast", "software rasterizer", "swiftshader")
MINIMUM_VERSION = 430


class NativeContext(Protocol):
    """Interface that moderngl needs of a context, see `egl.EglContext`."""

    def load(self, name: str) -> int:
        """Address of a GL function."""
        ...

    def __enter__(self) -> object:
        """Make current."""
        ...

    def __exit__(self, *_: object) -> None:
        """Restore what was current before."""
        ...

    def release(self) -> None:
        """Destroy."""
        ...


@dataclass(frozen=True)
class Attempt:
    """Outcome of trying one backend.

    Parameters
    ----------
    backend : str
        One of `BACKENDS`.
    detail : str
        Renderer and version, or what is wrong.
    remedy : str
        What to do where it failed.
    """

    backend: str
    ok: bool
    detail: str
    remedy: str = ""

    @property
    def hidden(self) -> bool:
        """Whether it was not tried, for `HIDE_VARIABLE` says so."""
        return self.detail == _HIDDEN_TEXT[0]


class GLContext:
    """An open OpenGL context; make one with `GLContext.open`, in a `with` statement.

    Attributes
    ----------
    ctx : moderngl.Context
    raw : RawGL
        The few calls that moderngl lacks.
    backend : str
    attempts : tuple of Attempt
        What was tried to get here, the last one with success.
    renderer, version : str
        As the driver names itself.
    hardware : bool
        Whether a GPU draws, rather than a software rasteriser.
    """

    def __init__(
        self, native: NativeContext, backend: str, attempts: tuple[Attempt, ...] = ()
    ) -> None:
        self.native, self.backend = native, backend
        settings: Any = {"context": native}  # moderngl's stubs know only of dicts here
        self.ctx = moderngl.create_context(require=MINIMUM_VERSION, **settings)
        self.renderer = str(self.ctx.info["GL_RENDERER"])
        self.version = str(self.ctx.info["GL_VERSION"])
        self.hardware = not any(name in self.renderer.lower() for name in SOFTWARE)
        self.raw = RawGL(native.load)
        self.attempts = (*attempts, Attempt(backend, True, f"{self.renderer}, {self.version}"))
        self._owner = os.getpid(), threading.get_ident()
        self._users = 1

    @classmethod
    def open(cls, backend: str = "auto") -> GLContext:
        """Open the process's context, or join it if it is open already.

        Parameters
        ----------
        backend : str
            One of `BACKENDS`, or "auto" for the first of them that works.

        Raises
        ------
        OpenGLError
            If no wanted backend works (the remedy names the package to install), or if another
            backend is open already.
        """
        wanted = _wanted(backend)
        if _Process.context is not None:
            return _join(_Process.context, wanted)
        # llvmpipe draws small windows fastest without worker threads; a user's choice stands
        os.environ.setdefault("LP_NUM_THREADS", "0")
        attempts: list[Attempt] = []
        for name in wanted:
            try:
                opened = _try(name, tuple(attempts))
            except OpenGLError as error:
                attempts.append(Attempt(name, False, error.problem, error.remedy))
            else:
                _Process.context = opened
                return opened
        raise NoOpenGLError(tuple(attempts))

    @staticmethod
    def of_process() -> GLContext | None:
        """The context that is open in this process, if any; nobody is added to its users."""
        return _Process.context

    @property
    def description(self) -> str:
        """Backend, renderer and version in one line."""
        return f"{self.backend}: {self.renderer}, OpenGL {self.version}"

    def __enter__(self) -> GLContext:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def current(self) -> NativeContext:
        """The scope that GL calls belong into: ``with gl.current(): ...``.

        Whatever else the process made current in between is restored afterwards.

        Raises
        ------
        OpenGLError
            If called after `close`, in another thread or in a forked child.
        """
        if self._users < 1:
            raise OpenGLError("the OpenGL context is closed", "open another one")
        if self._owner != (os.getpid(), threading.get_ident()):
            raise OpenGLError(
                "this process's OpenGL belongs to another thread, or to its parent process",
                "draw there, take the renderer 'cpu', or start processes by 'spawn'",
            )
        return self.native

    def close(self) -> None:
        """Leave the context; the last user destroys it and everything in it."""
        if self._users < 1:
            return
        self._users -= 1
        if self._users == 0:
            if _Process.context is self:
                _Process.context = None
            self.ctx.release()  # releases the native context too


class NoOpenGLError(OpenGLError):
    """No wanted backend works; `attempts` say why."""

    def __init__(self, attempts: tuple[Attempt, ...]) -> None:
        tried = "; ".join(f"{a.backend}: {a.detail}" for a in attempts)
        super().__init__(f"no OpenGL context can be made ({tried})", remedy_of(attempts))
        self.attempts = attempts


def remedy_of(attempts: tuple[Attempt, ...]) -> str:
    """The one thing to do, out of failed attempts: the package for the earliest usual backend."""
    by_name = {a.backend: a.remedy for a in attempts if not a.ok}
    for name in ("egl-surfaceless", "osmesa", "egl-device"):
        if by_name.get(name):
            return by_name[name]
    return egl.PACKAGES_EGL


class _Process:
    """The one context of this process."""

    context: GLContext | None = None


def _wanted(backend: str) -> tuple[str, ...]:
    if backend == "auto":
        return BACKENDS
    if backend not in BACKENDS:
        raise OpenGLError(
            f"there is no OpenGL backend named {backend}",
            f"choose one of auto, {', '.join(BACKENDS)}",
        )
    return (backend,)


def _join(context: GLContext, wanted: tuple[str, ...]) -> GLContext:
    visible = [name for name in wanted if name not in _hidden()]
    if not visible:
        raise NoOpenGLError(tuple(Attempt(n, False, *_HIDDEN_TEXT) for n in wanted))
    if context.backend not in visible:
        raise OpenGLError(
            f"this process has an {context.backend} context open already",
            "close it first, or ask for that one: there is one OpenGL context per process",
        )
    context.current()  # raises in another thread or a forked child
    context._users += 1
    return context


def _hidden() -> tuple[str, ...]:
    names = os.environ.get(HIDE_VARIABLE, "").split(",")
    return BACKENDS if "all" in names else tuple(names)


_HIDDEN_TEXT = (f"hidden by {HIDE_VARIABLE}", egl.PACKAGES_EGL)


def _try(name: str, before: tuple[Attempt, ...]) -> GLContext:
    if name in _hidden():
        raise OpenGLError(*_HIDDEN_TEXT)
    return _OPENERS[name](before)


def _wrap(native: NativeContext, name: str, before: tuple[Attempt, ...]) -> GLContext:
    try:
        return GLContext(native, name, before)
    except (moderngl.Error, ValueError) as error:
        native.release()
        raise OpenGLError(f"OpenGL 4.3 is needed ({error})", egl.PACKAGES_DRIVER) from error


def _device(before: tuple[Attempt, ...]) -> GLContext:
    """The first EGL device that really draws by hardware."""
    problem = "no EGL device is a GPU"
    for handle in egl.hardware_devices():
        try:
            opened = _wrap(egl.open_device(handle), "egl-device", before)
        except OpenGLError as error:
            problem = error.problem
            continue
        if opened.hardware:
            return opened
        problem = f"the EGL device draws by software ({opened.renderer})"
        opened.close()
    raise OpenGLError(problem, "install the driver of your GPU, or use egl-surfaceless")


_OPENERS: dict[str, Callable[[tuple[Attempt, ...]], GLContext]] = {
    "egl-device": _device,
    "egl-surfaceless": lambda before: _wrap(egl.open_surfaceless(), "egl-surfaceless", before),
    "osmesa": lambda before: _wrap(osmesa.open_osmesa(), "osmesa", before),
}
