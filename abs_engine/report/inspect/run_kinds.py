"""The kinds of picture that show how well a run fits: over its video, and beside its truth."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import Image
from abs_engine.core.errors import ParameterError
from abs_engine.core.kinds import checked_frame
from abs_engine.core.scene import Renderer
from abs_engine.evaluate.estimate import Estimate, check_run
from abs_engine.evaluate.same_clip import check_clip
from abs_engine.evaluate.score import error_map
from abs_engine.io.assets import load_speaker
from abs_engine.report.drawing.colours import HEAT_COLOURS
from abs_engine.report.drawing.layout import beside
from abs_engine.report.drawing.legend import colour_bar
from abs_engine.report.drawing.paint import paint, value_coat
from abs_engine.report.drawing.view import views_of
from abs_engine.report.inspect.body import Body, posed
from abs_engine.report.inspect.heads import FILM_VIEWS, person_of
from abs_engine.report.inspect.heat import heat_limits, read_values
from abs_engine.report.inspect.output import Film, Progress, presented
from abs_engine.report.inspect.overlay import OverlayPainter
from abs_engine.report.inspect.request import Request
from abs_engine.report.inspect.run_video import find_video
from abs_engine.report.inspect.runs import RunHead, load_run_head, run_pictures
from abs_engine.report.inspect.sheets import RATE, turn_angles
from abs_engine.report.inspect.sources import check_pair, open_truth

_AMBIENT = 0.8
"""Much of the light comes from everywhere, so that colours can be compared with the bar."""
_TURNS = (-40.0, 0.0, 40.0)


def draw_overlay(
    request: Request, renderer: Renderer, film: bool, progress: Progress | None
) -> Image | Film:
    """The head of a run over its video."""
    run = _run(request)
    palette = request.palette or "classes"
    enlarged = film or request.frame is not None
    painter = OverlayPainter(renderer, run, request.style, palette, enlarged)
    truth = None if request.truth is None else open_truth(request, request.truth, run.speaker)
    if truth is not None:
        check_pair(run, truth)
    video = find_video(run, request.video, None if truth is None else truth.video)

    def painted(wanted: list[int]) -> Iterator[Image]:
        for number, picture in run_pictures(video, wanted):
            yield painter.paint(number, picture)

    return presented(request, film, len(run), run.rate, painted, progress, run.uneven_times)


def draw_error(
    request: Request, renderer: Renderer, film: bool, progress: Progress | None
) -> Image | Film:
    """Errors painted on the head, from three sides; as a film it turns round."""
    body, values, text = _errors(request)
    size = request.size or (360, 420)
    if not film and request.views is not None:
        raise ParameterError("--views is for films here", "end the file's name in .mp4")
    limits = heat_limits(values, request.largest)
    turns = turn_angles(request.views or FILM_VIEWS) if film else _TURNS
    look = value_coat(values, limits, HEAT_COLOURS)
    views = views_of(body.vertices, size, turns)
    pictures = (paint(renderer, body, look, view, ambient=_AMBIENT) for view in views)
    bar = colour_bar(HEAT_COLOURS, limits, text, size[1])
    if film:
        return Film((beside([picture, bar]) for picture in pictures), len(views), RATE)
    made = beside([*pictures, bar])
    if progress is not None:
        progress(1, 1)
    return made


def _errors(request: Request) -> tuple[Body, NDArray[np.float64], str]:
    """The head, a number for each vertex, and what the numbers are.

    Of a run: the true head, and the RMS error of all frames, or the distance in one.
    """
    others = request.run is not None or request.truth is not None or request.frame is not None
    if request.values is not None and not others:
        body = posed(person_of(request), request.units)
        return body, read_values(request.values, len(body.vertices)), "mm"
    if request.values is not None or request.run is None or request.truth is None:
        raise ParameterError(
            "errors come from an array, or from a run with its dataset",
            "give --values FILE, or RUN --truth DIR",
        )
    run = _run(request)
    truth = open_truth(request, request.truth, run.speaker)
    check_pair(run, truth)
    check_run(run.arrays, len(truth), len(truth.neutral))
    check_clip(run.folder, run.arrays, truth)
    rest = Body(run.speaker, truth.neutral.astype(np.float64))
    if request.frame is None:
        found = np.asarray(run.arrays["found"], bool)
        if not found.any():
            raise ParameterError("the head was found in no frame", "give another run")
        values = error_map(Estimate(run.folder.name, found, surface=run.mesh), truth)
        return rest, values, "RMS error, mm"
    true = truth.vertices(checked_frame(request.frame, len(truth))).astype(np.float64)
    values = np.linalg.norm(run.body(request.frame).vertices - true, axis=1)
    return rest.moved(true), values, f"error in frame {request.frame}, mm"


def _run(request: Request) -> RunHead:
    if request.run is None:
        raise ParameterError(f"'{request.kind}' needs a run", "name the folder 'track -o' made")
    return load_run_head(request.run, load_speaker(request.speaker))
