"""The kinds of picture that show label buffers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from abs_engine.core.arrays import Image, evenly
from abs_engine.core.errors import ParameterError
from abs_engine.core.kinds import checked_frame
from abs_engine.core.scene import Renderer
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.report.drawing.layout import beside, captioned, framed
from abs_engine.report.drawing.view import views_of
from abs_engine.report.inspect.body import posed
from abs_engine.report.inspect.heads import FILM_VIEWS, person_of
from abs_engine.report.inspect.labels import LabelPainter, drawn_labels, limits_of
from abs_engine.report.inspect.output import SHEET_TILES, Film, Progress, presented
from abs_engine.report.inspect.request import Request
from abs_engine.report.inspect.runs import load_run_head
from abs_engine.report.inspect.sheets import RATE, turn_angles
from abs_engine.report.inspect.sources import LabelSource, open_truth, run_labels, truth_labels

_SAMPLED = 5  # frames of a film that its colour scale is taken from


def draw_label(
    request: Request, renderer: Renderer, film: bool, progress: Progress | None
) -> Image | Film:
    """Label buffers of a posture, a run or a dataset, with their legend."""
    kind, speaker = request.kind, load_speaker(request.speaker)
    source = _label_source(request, speaker, renderer, film)
    chosen = [checked_frame(request.frame, source.count)] if request.frame is not None else None
    if kind == "flow" and chosen == [source.count - 1]:
        raise ParameterError(
            f"no flow is known from frame {source.count - 1}, the last", "give a frame before it"
        )
    sampled = chosen or evenly(source.count, _SAMPLED if film else SHEET_TILES)
    painter = LabelPainter(kind, speaker, _limits(request, source, sampled))

    def painted(wanted: list[int]) -> Iterator[Image]:
        for frame in map(source.frame, wanted):
            picture = painter.picture(frame)
            if request.run is not None or request.truth is not None:
                picture = framed(picture)
            yield captioned(picture, frame.caption) if frame.caption else picture

    made = presented(request, film, source.count, source.rate, painted, progress, source.times)
    if isinstance(made, Film):
        return replace(made, frames=(_explained(p, painter) for p in made.frames))
    return _explained(made, painter)


def _explained(picture: Image, painter: LabelPainter) -> Image:
    """The picture with its legend, if it has one."""
    told = painter.legend(max(picture.shape[0], 200) if picture.shape[0] < 600 else 480)
    return picture if told is None else beside([picture, told])


def _limits(request: Request, source: LabelSource, sampled: Sequence[int]) -> tuple[float, float]:
    if request.limits is not None:
        if not -np.inf < request.limits[0] < request.limits[1] < np.inf:
            raise ParameterError("--range ends where it begins or before", "give LOW then HIGH")
        return request.limits
    if request.largest is not None:
        if not 0 < request.largest < np.inf:
            raise ParameterError(f"--max is {request.largest:g}", "give a number above 0")
        return 0.0, request.largest
    return limits_of(request.kind, [source.frame(n) for n in sampled])


def _label_source(
    request: Request, speaker: Speaker, renderer: Renderer, film: bool
) -> LabelSource:
    if request.truth is not None and request.run is not None:
        raise ParameterError("labels come from a run or from a dataset", "give only one of them")
    if request.truth is not None:
        return truth_labels(open_truth(request, request.truth, speaker, request.kind))
    if request.run is not None:
        return run_labels(renderer, load_run_head(request.run, speaker))
    if request.kind in ("albedo", "flow"):
        raise ParameterError(f"{request.kind} is stored in datasets only", "give one with --truth")
    if request.frame is not None:
        raise ParameterError("a posture has no frames", "give a run or --truth")
    rest = person_of(request)
    turns = [request.turn]
    if film or request.views is not None:
        turns = turn_angles(request.views or FILM_VIEWS)
    size = request.size or ((240, 280) if len(turns) > 1 and not film else (512, 512))
    views = views_of(rest.shown(request.shown), size, turns)
    captions = ["" if film or len(turns) == 1 else f"{t:.0f}°" for t in turns]
    body = posed(rest, request.units)
    return LabelSource(
        RATE, len(views), lambda k: drawn_labels(renderer, body, views[k], captions[k])
    )
