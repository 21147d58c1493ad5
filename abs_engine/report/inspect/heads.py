"""The kinds of picture that show heads alone: portraits, turntables, postures, nomograms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from abs_engine.core.arrays import Image
from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import Renderer
from abs_engine.face.schema import Unit
from abs_engine.face.shape.mouth import mouth_shape
from abs_engine.io.assets import load_speaker
from abs_engine.report.drawing.layout import captioned, columns_of, sheet
from abs_engine.report.drawing.view import views_of
from abs_engine.report.inspect.body import Body, person_body, posed
from abs_engine.report.inspect.output import Film, Progress
from abs_engine.report.inspect.request import Request
from abs_engine.report.inspect.runs import load_run_head
from abs_engine.report.inspect.sheets import (
    RATE,
    SWEEP,
    Look,
    Row,
    mode_rows,
    nomogram,
    posture_sheet,
    sweep_film,
    turn_angles,
    unit_rows,
)

_WITH: dict[str, str] = {Unit.MOUTH_CLOSE: Unit.JAW_OPEN}
"""Face units that close what another opens, and alone make lips cross."""

SHEET_VIEWS, FILM_VIEWS = 8, 100
"""Views of a turntable on a sheet and in a film."""


def draw_portrait(
    request: Request, renderer: Renderer, film: bool, _progress: Progress | None
) -> Image | Film:
    """A head in a posture; as a film it turns round."""
    if film:
        return draw_turntable(request, renderer, film, None)
    if request.views is not None:
        raise ParameterError("one picture has no --views", "ask for a turntable, or for an MP4")
    look = _look(request, renderer, (512, 512))
    body = person_of(request)
    return look.draw(posed(body, request.units), look.view(body))


def draw_turntable(
    request: Request, renderer: Renderer, film: bool, progress: Progress | None
) -> Image | Film:
    """A head in a posture from all sides, as a sheet or a film."""
    look = _look(request, renderer, (480, 540) if film else (240, 280))
    rest = person_of(request)
    body = posed(rest, request.units)
    turns = turn_angles(request.views or (FILM_VIEWS if film else SHEET_VIEWS))
    views = views_of(rest.shown(look.crop), look.size, turns)
    pictures = (look.draw(body, view) for view in views)
    if film:
        return Film(pictures, len(views), RATE)
    tiles = [captioned(p, f"{t:.0f}°") for p, t in zip(pictures, turns, strict=True)]
    if progress is not None:
        progress(len(tiles), len(tiles))
    return sheet(tiles, columns_of(len(tiles), look.size))


def draw_postures(
    request: Request, renderer: Renderer, film: bool, progress: Progress | None
) -> Image | Film:
    """Every face unit alone, as a sheet; as a film each comes and goes."""
    look = _look(request, renderer, (360, 420) if film else (180, 210))
    body = posed(person_of(request), request.units)
    rows = _units(body, request)
    if film:
        return _sweep(look, body, rows, (0.0, request.weight), "")
    first = "posture of --unit" if request.units else "at rest"
    return posture_sheet(look, body, rows, request.weight, progress, first)


def draw_nomogram(
    request: Request, renderer: Renderer, film: bool, progress: Progress | None
) -> Image | Film:
    """Face units or modes from low to high, row by row; as a film each goes up and down."""
    look = _look(request, renderer, (360, 420) if film else (150, 175))
    body, rows, signed = _directions(request)
    if request.run is not None and request.palette is None:
        look = Look(renderer, look.size, "classes", look.crop, look.turn)
    low, high, unit = (-3.0, 3.0, "sd") if signed else (0.0, 1.0, "")
    if film:
        return _sweep(look, body, rows, (low, high), unit)
    columns = request.columns or (7 if signed else 5)
    if columns < 2:
        raise ParameterError("a nomogram needs two columns or more", "give --columns 5, say")
    values = [float(v) for v in np.linspace(low, high, columns)]
    return nomogram(look, body, rows, values, unit, progress)


def _directions(request: Request) -> tuple[Body, list[Row], bool]:
    """The head a nomogram starts from, its rows, and whether they go both ways."""
    if (request.modes is not None or request.run is not None) and request.rows:
        raise ParameterError("--rows names face units, not modes", "leave one of them out")
    if request.run is not None:
        run = load_run_head(request.run, load_speaker(request.speaker))
        held = len(run.mesh.modes)
        if request.modes is not None and request.modes > held:
            raise ParameterError(
                f"{request.modes} modes asked for, the run's head has {held}", "ask for less"
            )
        modes, names = run.mesh.modes[: request.modes], run.mode_names[: request.modes]
        return Body(run.speaker, run.mesh.mean.astype(np.float64)), mode_rows(modes, names), True
    person = person_of(request)
    if request.modes is None:
        body = posed(person, request.units)
        return body, _units(body, request), False
    shape = mouth_shape(person.speaker, person.vertices.astype(np.float32), request.modes)
    return posed(person.moved(shape.mean), request.units), mode_rows(shape.modes), True


def _units(body: Body, request: Request) -> list[Row]:
    """The face units that are named as they are; of all, those that go with another beside it."""
    given = request.units
    rows = {
        row.name: replace(row, held=given.get(row.name, 0.0) * row.delta)
        for row in unit_rows(body, request.rows)
    }
    if request.rows:
        return list(rows.values())
    return [_joined(row, rows.get(_WITH.get(name, ""))) for name, row in rows.items()]


def _joined(row: Row, other: Row | None) -> Row:
    """A row, with another that goes with it."""
    if other is None:
        return row
    return Row(f"{row.name}, {other.name}", row.delta + other.delta, row.held + other.held)


def _sweep(
    look: Look, body: Body, rows: Sequence[Row], limits: tuple[float, float], unit: str
) -> Film:
    return Film(sweep_film(look, body, rows, *limits, unit), SWEEP * len(rows), RATE)


def person_of(request: Request) -> Body:
    """The person who is asked for, at rest."""
    speaker = load_speaker(request.speaker)
    return person_body(speaker, request.person or next(iter(speaker.people)))


def _look(request: Request, renderer: Renderer, size: tuple[int, int]) -> Look:
    return Look(
        renderer, request.size or size, request.palette or "colour", request.shown, request.turn
    )
