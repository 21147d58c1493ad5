"""Opens what draws, and says on one line what it is."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING

from abs_engine.cli.parts.progress import asked, interject, say

if TYPE_CHECKING:
    from abs_engine.core.scene import Renderer


@contextmanager
def opened(name: str) -> Iterator[Renderer]:
    """Open a renderer and say what it is, and why OpenGL is not used if it failed.

    A long compilation within is announced, too.
    """
    from logging.handlers import BufferingHandler

    from abs_engine.cli.parts.compilation import compilation_noticed
    from abs_engine.render.select import opened_renderer

    notes = BufferingHandler(capacity=1000)
    notes.setLevel(logging.WARNING)
    logger = logging.getLogger("abs_engine.render")
    quiet = asked("quiet")  # here: threads that compile know no command
    with ExitStack() as stack:
        logger.addHandler(notes)
        try:
            renderer = stack.enter_context(opened_renderer(name))
        finally:
            logger.removeHandler(notes)
        if not quiet:
            stack.enter_context(compilation_noticed(interject))
        lines = [" ".join(record.getMessage().split()) for record in notes.buffer]
        note(f"renderer: {renderer.description}" + (f" ({'; '.join(lines)})" if lines else ""))
        yield renderer


def print_hints(renderer: Renderer) -> None:
    """Print hints for a user before a long run."""
    from abs_engine.render.select import draws_by_software

    if draws_by_software(renderer):
        note("hint: no GPU draws here; --renderer cpu is faster than OpenGL")


def note(line: str) -> None:
    """Say what is no part of the answer, unless `--quiet` was typed."""
    if not asked("quiet"):
        say(line)
