"""From a request to a picture or a film on disk."""

from __future__ import annotations

from collections.abc import Callable

from abs_engine.core.arrays import Image
from abs_engine.core.scene import Renderer
from abs_engine.io.files import check_free, png, write_new
from abs_engine.io.video import film_bytes
from abs_engine.report.inspect.heads import (
    draw_nomogram,
    draw_portrait,
    draw_postures,
    draw_turntable,
)
from abs_engine.report.inspect.label_kinds import draw_label
from abs_engine.report.inspect.output import Film, Progress, even_sided, is_film, reported
from abs_engine.report.inspect.request import LABEL_KINDS, Request
from abs_engine.report.inspect.run_kinds import draw_error, draw_overlay

_KINDS: dict[str, Callable[[Request, Renderer, bool, Progress | None], Image | Film]] = {
    "portrait": draw_portrait,
    "turntable": draw_turntable,
    "postures": draw_postures,
    "nomogram": draw_nomogram,
    "overlay": draw_overlay,
    "error": draw_error,
    **dict.fromkeys(LABEL_KINDS, draw_label),
}


def render_to_file(request: Request, renderer: Renderer, progress: Progress | None = None) -> None:
    """Draw what is asked for and write it.

    Parameters
    ----------
    progress : callable, optional
        Called with the number of pictures done and of all.

    Raises
    ------
    OutputError
        If the file exists or cannot be written.
    ParameterError
        If the request does not make sense: an unknown name, a frame that is not there.
    InputFileError
        If a run, a dataset, a video or an array cannot be read.
    """
    check_free(request.output)
    film = is_film(request.output)
    made = _KINDS[request.kind](request, renderer, film, progress)
    if isinstance(made, Film):
        frames = map(even_sided, reported(made.frames, made.count, progress))
        content = film_bytes(frames, made.rate, times=made.times)
    else:
        content = png(made)
    write_new(request.output, content)
