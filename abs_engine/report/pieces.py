"""Small pieces of HTML that several parts of the page use."""

from __future__ import annotations

from abs_engine.report.data import ReportData
from abs_engine.report.document import safe
from abs_engine.report.drawing.colours import Stroke, system_stroke, truth_stroke


def key(data: ReportData) -> str:
    """The legend of all curves, to be read beside each chart."""
    named = [("truth", truth_stroke())] if data.true is not None else []
    named += [(s.name, system_stroke(k)) for k, s in enumerate(data.systems)]
    items = "".join(f"<li>{swatch(stroke)}{safe(name)}</li>" for name, stroke in named)
    if data.true is not None:
        items += '<li><span class="swatch area" style="background:#dddde3"></span>'
        items += "lips truly closed</li>"
    return f'<ul class="legend">{items}</ul>'


def swatch(stroke: Stroke) -> str:
    """A piece of a line, as it is drawn."""
    gaps = " ".join(map(str, stroke.gaps)) or "none"
    line = (
        f'<line x1="0" y1="50%" x2="44" y2="50%" stroke="{stroke.colour}" '
        f'stroke-width="{stroke.width:g}" stroke-dasharray="{gaps}"/>'
    )
    return f'<svg class="swatch" width="44" height="8" aria-hidden="true">{line}</svg>'
