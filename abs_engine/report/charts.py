"""The charts of a report, drawn by plotly in the browser."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from plotly.graph_objects import Box, Figure, Scatter
from plotly.subplots import make_subplots

from abs_engine.core.arrays import BoolArray, FloatArray, stretches
from abs_engine.dataset import Phoneme
from abs_engine.report.data import Quantity, ReportData, Series, System
from abs_engine.report.drawing import colours
from abs_engine.report.quantities import CURVES, SHARE
from abs_engine.tracking.frame.frame_times import usual_duration

SHOWN_SECONDS = 10.0
"""Longer clips begin with this part; a double click shows the whole."""

_FONT = "Inter, 'Helvetica Neue', Arial, sans-serif"
_GRID = "#e6e6e6"
_LAYOUT: dict[str, Any] = {
    "template": "none",
    "font": {"family": _FONT, "size": 13, "color": "#333"},
    "margin": {"l": 76, "r": 16, "t": 30, "b": 48},
    "hovermode": "x unified",
    "dragmode": "zoom",
    "showlegend": False,
    "paper_bgcolor": "white",
    "plot_bgcolor": "white",
}
_Line = NDArray[np.float32]
_ROW, _SAID_ROW = 150, 34  # px
_LEAST = 0.1  # mm, px or degrees: axes of errors go that far
_LONG = 13  # letters: longer names of an axis take two lines


def lip_chart(data: ReportData) -> Figure | None:
    """Lip curves against the truth: phonemes above, true closures shaded; None without curves."""
    true = data.true.curves if data.true is not None else {}
    rows = [q for q in CURVES if q.key in true or _given(data.systems, "curves", q.key)]
    if not rows:
        return None
    said = data.true.said if data.true is not None else ()
    figure = _rows(rows, above=bool(said))
    first = 2 if said else 1
    for row, quantity in enumerate(rows, first):
        if quantity.key in true:
            _line(figure, row, data, true[quantity.key], "truth", colours.truth_stroke())
        for number, system in enumerate(data.systems):
            if quantity.key in system.curves:
                _series(figure, row, data, system.curves[quantity.key], number)
    if said:
        _say(figure, said)
    return _timed(figure, data, len(rows), bool(said))


def frame_chart(data: ReportData, part: str, quantities: Sequence[Quantity]) -> Figure | None:
    """Errors over time, or how uncertain, a row for each quantity; None where there are none."""
    rows = [q for q in quantities if _given(data.systems, part, q.key)]
    if not rows:
        return None
    figure = _rows(rows)
    for row, quantity in enumerate(rows, 1):
        for number, system in enumerate(data.systems):
            series = getattr(system, part).get(quantity.key)
            if series is not None:
                _series(figure, row, data, series, number)
        figure.update_yaxes(**_from_nought(quantity), row=row, col=1)
    return _timed(figure, data, len(rows), False)


def box_chart(data: ReportData) -> Figure | None:
    """Chart of the spread of the frames' errors; None without errors."""
    rows = [q for q in data.errors if q.unit != SHARE and _given(data.systems, "errors", q.key)]
    if not rows:
        return None
    columns = min(len(rows), 3)
    lines = -(-len(rows) // columns)
    titles = ["<br>".join(q.label.rsplit(" ", 1)) + f", {q.unit}" for q in rows]  # for phones
    figure = make_subplots(
        lines, columns, subplot_titles=titles, vertical_spacing=0.16 / lines + 0.06,
        horizontal_spacing=0.08,
    )  # fmt: skip
    for place, quantity in enumerate(rows):
        at = {"row": place // columns + 1, "col": place % columns + 1}
        for number, system in enumerate(data.systems):
            if quantity.key in system.errors:
                _box(figure, system.errors[quantity.key].values, system.name, number, at)
        figure.update_yaxes(**_from_nought(quantity), gridcolor=_GRID, zeroline=False, **at)
    figure.update_xaxes(showticklabels=False)
    figure.update_annotations(font_size=13)
    layout = _LAYOUT | {"hovermode": "closest", "height": 270 * lines}
    figure.update_layout(**(layout | {"margin": {"l": 48, "r": 16, "t": 68, "b": 16}}))
    return figure


def _from_nought(quantity: Quantity) -> dict[str, Any]:
    """An axis from 0 on, which does not enlarge rounding errors; to 1 for shares."""
    least = 1.0 if quantity.unit == SHARE else _LEAST
    return {"rangemode": "tozero", "autorangeoptions": {"include": [0, least]}}


def _given(systems: Sequence[System], part: str, key: str) -> bool:
    return any(key in getattr(system, part) for system in systems)


def _rows(rows: Sequence[Quantity], above: bool = False) -> Figure:
    """Empty charts one below the other, perhaps with a narrow row above for what is said."""
    heights = [_SAID_ROW] * above + [_ROW] * len(rows)
    figure = make_subplots(
        len(heights), 1, shared_xaxes=True, row_heights=heights, vertical_spacing=0.025
    )
    for row, quantity in enumerate(rows, 1 + above):
        between = ",<br>" if len(quantity.label) > _LONG else ", "
        title = f"{quantity.label}{between}{quantity.unit}"
        figure.update_yaxes(title_text=title, row=row, col=1)
    return figure


def _timed(figure: Figure, data: ReportData, rows: int, above: bool) -> Figure:
    """Shade true closures of a chart over time, and settle its axes and size."""
    if data.true is not None:
        _shade(figure, data.true.closed, data.rate)
    times = data.times
    step = usual_duration(times, data.rate)
    end = min(times[-1] + step, times[0] + SHOWN_SECONDS)
    figure.update_xaxes(
        range=[times[0] - step / 2, end], gridcolor=_GRID, zeroline=False, showline=True,
        linecolor="#999", ticks="outside", tickcolor="#999",
    )  # fmt: skip
    figure.update_yaxes(gridcolor=_GRID, zeroline=False, title_standoff=8, title_font_size=13)
    figure.update_xaxes(title_text="time, s", title_font_size=13, row=rows + above, col=1)
    if above:
        figure.update_yaxes(range=[0, 1], showticklabels=False, showgrid=False, row=1, col=1)
        figure.update_xaxes(showgrid=False, showline=False, ticks="", row=1, col=1)
    figure.update_layout(**_LAYOUT, height=rows * _ROW + above * _SAID_ROW + 80)
    return figure


def _series(figure: Figure, row: int, data: ReportData, series: Series, number: int) -> None:
    """A system's line, with its interval behind it."""
    if series.lower is not None and series.upper is not None:
        red, green, blue = colours.rgb(colours.system_colour(number))
        x, y = _outline(data.times, series.lower, series.upper)
        band = Scatter(
            x=x, y=y, name="", mode="none", hoverinfo="skip", fill="toself",
            fillcolor=f"rgba({red},{green},{blue},0.18)",
        )  # fmt: skip
        figure.add_trace(band, row=row, col=1)
    name, stroke = data.systems[number].name, colours.system_stroke(number)
    _line(figure, row, data, series.values, name, stroke)


def _outline(times: FloatArray, lower: FloatArray, upper: FloatArray) -> tuple[_Line, _Line]:
    """A band's outline: there along the lower edge, back along the upper; NaN ends a stretch.

    Plotly would fill the space between two lines across their gaps.
    """
    x: list[ArrayLike] = []
    y: list[ArrayLike] = []
    for start, end in stretches(np.isfinite(lower) & np.isfinite(upper)):
        there, back = slice(start, end), slice(end - 1, start - 1 if start else None, -1)
        x += [times[there], times[back], [np.nan]]
        y += [lower[there], upper[back], [np.nan]]
    return _joined(x), _joined(y)


def _joined(parts: Sequence[ArrayLike]) -> _Line:
    return np.concatenate([np.zeros(0), *parts]).astype(np.float32)


def _line(
    figure: Figure,
    row: int,
    data: ReportData,
    values: FloatArray,
    name: str,
    stroke: colours.Stroke,
) -> None:
    trace = Scatter(
        x=data.times.astype(np.float32), y=values.astype(np.float32), name=name, mode="lines",
        line={"color": stroke.colour, "width": stroke.width, "dash": stroke.dash},
        hovertemplate="%{y:.2f}",
    )  # fmt: skip
    figure.add_trace(trace, row=row, col=1)
    alone = [start for start, end in stretches(np.isfinite(values)) if end == start + 1]
    if alone:  # which have no line
        dots = Scatter(
            x=data.times[alone].astype(np.float32), y=values[alone].astype(np.float32), name="",
            mode="markers", marker={"color": stroke.colour, "size": 6}, hoverinfo="skip",
        )  # fmt: skip
        figure.add_trace(dots, row=row, col=1)


def _say(figure: Figure, said: Sequence[Phoneme]) -> None:
    """Phonemes on the time axis: their symbols, and lines where they begin."""
    middle = [(s.start + s.end) / 2 for s in said]
    spans = [f"{s.start:.2f} to {s.end:.2f} s" for s in said]
    trace = Scatter(
        x=middle, y=[0.5] * len(said), text=[s.label for s in said], mode="text",
        textfont={"size": 13, "color": "#111"}, customdata=spans,
        hovertemplate="%{text}, %{customdata}<extra></extra>",
    )  # fmt: skip
    figure.add_trace(trace, row=1, col=1)
    for k, one in enumerate(said):
        fill = "#f1f1ee" if k % 2 else "#e3e3de"
        figure.add_shape(
            type="rect", x0=one.start, x1=one.end, y0=0, y1=1, fillcolor=fill, line_width=0,
            layer="below", row=1, col=1,
        )  # fmt: skip


def _shade(figure: Figure, closed: BoolArray, rate: float) -> None:
    """Shade the runs of true closures, each from half a frame before to half a frame after."""
    for start, end in stretches(closed):
        figure.add_shape(
            type="rect", xref="x", yref="paper", y0=0, y1=1, layer="below", line_width=0,
            x0=(start - 0.5) / rate, x1=(end - 0.5) / rate, fillcolor="rgba(120,120,140,0.18)",
        )  # fmt: skip


def _box(figure: Figure, values: FloatArray, name: str, number: int, at: dict[str, int]) -> None:
    known = values[np.isfinite(values)]
    box = Box(
        y=known.astype(np.float32), name=name, boxmean=True, boxpoints="outliers",
        line={"color": colours.system_colour(number), "width": 1.6}, marker={"size": 3},
    )  # fmt: skip
    figure.add_trace(box, **at)
