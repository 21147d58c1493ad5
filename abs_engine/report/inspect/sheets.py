"""Face units and modes on a page: postures, nomograms, turntables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import Renderer
from abs_engine.report.drawing.layout import beside, captioned, columns_of, label, sheet, stacked
from abs_engine.report.drawing.paint import paint
from abs_engine.report.drawing.view import View, views_of
from abs_engine.report.inspect.body import Body, check_units, coat
from abs_engine.report.inspect.output import Progress, reported

RATE = 25.0
"""Frames a second of films that are made here."""
SWEEP = 26
"""Frames in which a film goes through one unit or mode."""
HEADED = 12
"""Rows of a nomogram below each line of column heads."""


@dataclass(frozen=True, eq=False)
class Look:
    """Style of heads on a page.

    Parameters
    ----------
    size : tuple of int
        Width and height of one picture, pixels.
    palette : str
        One of `body.PALETTES`.
    turn : float
        Degrees by which the head turns to its left.
    """

    renderer: Renderer
    size: tuple[int, int]
    palette: str = "colour"
    crop: str = "head"
    turn: float = 0.0

    def view(self, body: Body) -> View:
        """The view of a body at rest."""
        return views_of(body.shown(self.crop), self.size, (self.turn,))[0]

    def draw(self, body: Body, view: View) -> Image:
        """The body as it is, (H, W, 3) uint8 RGB."""
        return paint(self.renderer, body, coat(body, self.palette), view)


@dataclass(frozen=True, eq=False)
class Row:
    """One direction in which the head moves.

    Parameters
    ----------
    delta : (V, 3) float64, mm at 1
    held : (V, 3) float64 or float, mm
        What the posture that the row starts from has of it already.
    """

    name: str
    delta: FloatArray
    held: FloatArray | float = 0.0

    def moved(self, body: Body, value: float) -> Body:
        """The body with so much of the direction, in place of what it holds of it."""
        return body.moved(body.vertices - self.held + value * self.delta)


def unit_rows(body: Body, names: Sequence[str] = ()) -> list[Row]:
    """Rows of the named face units, or of all.

    Raises
    ------
    ParameterError
        If there is no such face unit; the nearest is named.
    """
    check_units(body.speaker, names)
    chosen = tuple(names) or body.speaker.unit_names
    deltas = body.speaker.unit_matrix(chosen).astype(np.float64)
    return [Row(name, delta) for name, delta in zip(chosen, deltas, strict=True)]


def mode_rows(modes: NDArray[np.floating], names: Sequence[str] = ()) -> list[Row]:
    """Rows of a model's modes (P, V, 3), mm for one standard deviation; numbered without names."""
    names = names or [f"mode {k + 1}" for k in range(len(modes))]
    return [Row(name, np.asarray(m, np.float64)) for name, m in zip(names, modes, strict=True)]


def posture_sheet(
    look: Look,
    body: Body,
    rows: Sequence[Row],
    weight: float,
    progress: Progress | None = None,
    first: str = "at rest",
) -> Image:
    """The body as it is, called `first`, then with each row at a weight; the name is below each."""
    view = look.view(body)
    tiles = [captioned(look.draw(body, view), first)]
    for row in reported(rows, len(rows), progress):
        tiles.append(captioned(look.draw(row.moved(body, weight), view), row.name))
    return sheet(tiles, columns_of(len(tiles), look.size))


def nomogram(
    look: Look,
    body: Body,
    rows: Sequence[Row],
    values: Sequence[float],
    unit: str,
    progress: Progress | None = None,
) -> Image:
    """A row of pictures for each row, a column for each value: (H, W, 3) uint8 RGB.

    Parameters
    ----------
    body : Body
        What every value adds to.
    unit : str
        What the values are in, such as "sd"; may be empty.
    """
    view, wide = look.view(body), look.size[0]
    margin = 124
    heads = [label("", (margin, 24))]
    heads += [label(value_text(v, unit), (wide + 4, 24)) for v in values]
    lines = [beside(heads)]
    for number, row in enumerate(reported(rows, len(rows), progress)):
        if number and number % HEADED == 0:
            lines.append(lines[0])
        tiles = [look.draw(row.moved(body, v), view) for v in values]
        spaced = [np.pad(t, ((2, 2), (2, 2), (0, 0)), constant_values=255) for t in tiles]
        lines.append(beside([label(row.name, (margin, look.size[1]), align="right"), *spaced]))
    return stacked(lines)


def sweep_film(
    look: Look, body: Body, rows: Sequence[Row], low: float, high: float, unit: str
) -> Iterator[Image]:
    """Frames in which each row in turn goes from 0 to `high`, to `low`, and back."""
    view = look.view(body)
    phase = np.arange(SWEEP) / SWEEP
    one_way = high * 0.5 * (1 - np.cos(2 * np.pi * phase))
    both = np.where(phase < 0.5, high, -low) * np.sin(2 * np.pi * phase)
    for row in rows:
        for value in both if low < 0 else one_way:
            text = f"{row.name}  {value_text(value, unit, 2)}"
            yield captioned(look.draw(row.moved(body, value), view), text, 15)


def value_text(value: float, unit: str, digits: int | None = None) -> str:
    """A number with its sign where it has a unit, such as '+1 sd', or plain, such as '0.25'."""
    number = f"{value:.{digits}f}" if digits is not None else f"{value:.3g}"
    if not unit:
        return number.replace("-", "\N{MINUS SIGN}")
    sign = "+" if float(number) > 0 else ""
    return f"{sign}{number} {unit}".replace("-", "\N{MINUS SIGN}")


def turn_angles(count: int) -> list[float]:
    """Angles, degrees, evenly around from 0."""
    if count < 2:
        raise ParameterError(f"{count} views are not a turntable", "give 2 or more")
    return [360.0 * k / count for k in range(count)]
