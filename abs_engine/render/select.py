"""Choosing a renderer by name, with the CPU rasteriser behind OpenGL."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, Protocol, cast

from abs_engine.core.errors import AbsEngineError, OpenGLError, ParameterError, PluginError
from abs_engine.core.foreign import FAILURES, blamed, own
from abs_engine.core.kinds import TEXT, check_kind
from abs_engine.core.registry import RENDERERS, nearest
from abs_engine.core.scene import Renderer
from abs_engine.render.context import BACKENDS, HIDE_VARIABLE, NoOpenGLError
from abs_engine.render.cpu import CpuRenderer
from abs_engine.render.raster import OpenGLRenderer
from abs_engine.render.trial import check_renderer

NAMES = ("auto", "gl", *BACKENDS, "cpu")
"""What `open_renderer` takes."""

_log = logging.getLogger(__name__)


class OpenRenderer(Renderer, Protocol):
    """A renderer that closes itself at the end of a `with` statement."""

    def __enter__(self) -> OpenRenderer:
        """The renderer itself."""
        ...

    def __exit__(self, *_: object) -> None:
        """Close it."""
        ...


def open_renderer(name: str | None = "auto") -> OpenRenderer:
    """Open a renderer.

    Parameters
    ----------
    name : str, optional
        "auto", the default: OpenGL, or the CPU rasteriser with a line in the log where no OpenGL
        loads.
        "gl": any OpenGL or an error. "egl-device", "egl-surfaceless", "osmesa": that backend or
        an error. "cpu": the CPU rasteriser. Or one of `core.registry.RENDERERS`.

    Returns
    -------
    OpenRenderer
        Its `description` says what draws.

    Raises
    ------
    OpenGLError
        If OpenGL was asked for and cannot be had; the remedy names the package to install.
    ParameterError
        If there is no such name.
    PluginError
        If it is that of another package, and cannot be imported, or does not draw as it must.
    """
    name = "auto" if name is None else name
    check_kind("renderer", name, TEXT)
    if name not in NAMES:
        return _registered(name)
    if name == "cpu":
        return CpuRenderer()
    if name != "auto":
        return OpenGLRenderer("auto" if name == "gl" else name)
    try:
        return OpenGLRenderer("auto")
    except OpenGLError as error:
        _log.warning("%s", _why_not(error))
        return CpuRenderer()


def _registered(name: str) -> OpenRenderer:
    """A renderer that another package brings."""
    if name not in RENDERERS:
        raise ParameterError(f"there is no renderer '{name}'", nearest(name, [*NAMES, *RENDERERS]))
    make = RENDERERS.get(name)
    with blamed(f"the renderer '{name}'"):
        opened: OpenRenderer = make()
    if not (hasattr(opened, "__enter__") and hasattr(opened, "__exit__")):
        raise PluginError(
            f"the renderer '{name}' cannot be used in a 'with' statement",
            "give it __enter__, which returns it, and __exit__, which closes it",
        )
    try:
        check_renderer(name, opened)
    except AbsEngineError:
        with suppress(*FAILURES):  # what was wrong first is what counts
            opened.close()
        raise
    return opened


@contextmanager
def opened_renderer(name: str | None = "auto") -> Iterator[Renderer]:
    """A renderer that `open_renderer` opens, closed at the end.

    If a plugin's cannot be closed, that is only warned of: what it drew is not affected.
    """
    opened = open_renderer(name)
    if own(type(opened)):
        with opened:
            yield opened
        return
    with blamed(f"the renderer '{name}'"):
        drawn = opened.__enter__()
    try:
        yield cast("Renderer", _Named(f"the renderer '{name}'", drawn))
    finally:
        try:
            with blamed(f"closing the renderer '{name}'"):
                opened.__exit__(None, None, None)
        except AbsEngineError as error:
            _log.warning("%s", error)


class _Named:
    """A plugin's renderer of which each method that fails names it.

    An instance of the plugin's class to `isinstance`, as that may be one of the engine's, too.
    """

    def __init__(self, what: str, renderer: Renderer) -> None:
        self._what, self._renderer = what, renderer

    @property  # type: ignore[misc]
    def __class__(self) -> type:
        return type(self._renderer)

    def __getattr__(self, name: str) -> Any:
        part = getattr(self._renderer, name)
        if not callable(part):
            return part

        def called(*given: Any, **named: Any) -> Any:
            with blamed(self._what):
                return part(*given, **named)

        return called


def draws_by_software(renderer: Renderer) -> bool:
    """Whether OpenGL draws without a GPU: the CPU rasteriser is faster then."""
    return isinstance(renderer, OpenGLRenderer) and not renderer.gl.hardware


def _why_not(error: OpenGLError) -> str:
    """Reason why OpenGL is not used, short; `abs-engine doctor` says more."""
    attempts = error.attempts if isinstance(error, NoOpenGLError) else ()
    if attempts and all(attempt.hidden for attempt in attempts):
        return f"OpenGL is hidden by {HIDE_VARIABLE}"
    if not attempts:
        return f"the CPU draws, as {error.problem}"
    return f"no OpenGL loads; to get it: {error.remedy}"
