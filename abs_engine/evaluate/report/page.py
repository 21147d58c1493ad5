"""The page: one HTML file that opens from disk and needs nothing from outside."""

from __future__ import annotations

import html
import json
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray
from plotly.offline import get_plotlyjs

from abs_engine.evaluate.report import charts, colours, sections
from abs_engine.evaluate.report.data import FloatArray, Head, ReportData
from abs_engine.evaluate.report.embed import packed, packed_motion, script_json, text64

_WEB = "web"
_SCRIPTS = ("arrays.js", "heads.js", "stage.js", "player.js", "main.js")

# What a browser may load for the page: nothing but what is in it.
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; media-src data: blob:; font-src data:"
)


def report_page(data: ReportData) -> str:
    """The whole page as HTML.

    Parameters
    ----------
    data : ReportData
    """
    told = page_data(data)
    body = "\n".join(
        part
        for part in (
            sections.heading(data),
            sections.player(data),
            sections.lip_curves(data, told["charts"]),
            sections.errors(data, told["charts"]),
            sections.error_maps(data, told["ramp"]["end"]),
            sections.worst(data),
            sections.scores(data),
            sections.facts(data),
        )
        if part
    )
    scripts = "\n".join(_script(name) for name in _SCRIPTS)
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{_POLICY}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{html.escape(data.title)}</title>
<style>{_text("page.css")}</style>
<script>{_closed(get_plotlyjs())}</script></head>
<body><main>
<noscript><p class="warning">This page draws its charts with JavaScript; allow it to run.</p>
</noscript>
{body}
</main>
<script type="application/json" id="data">{script_json(told)}</script>
{scripts}
</body></html>
"""


def page_data(data: ReportData) -> dict[str, Any]:
    """What the page's scripts are told, as JSON values."""
    area = slice(None) if data.area is None else data.area
    maps = [s.error_map[area] for s in data.systems if s.error_map is not None]
    drawn = {
        "lips": charts.lip_chart(data),
        "errors": charts.error_chart(data),
        "boxes": charts.box_chart(data),
    }
    said = data.true.said if data.true is not None else ()
    return {
        "rate": data.rate,
        "played": data.played,
        "vertices": len(data.colours),
        "focus": list(data.focus),
        "weld": packed(weld(data)),
        "faces": packed(data.faces.astype(np.uint32).ravel()),
        "colours": packed(data.colours),
        "heads": _heads(data),
        "contours": _contours(data),
        "film": None
        if data.film is None
        else {"data": text64(data.film.content), "size": list(data.film.size)},
        "said": [[s.label, s.start, s.end] for s in said],
        "ramp": {"colours": packed(colours.bar_colours()), "end": colours.scale_end(maps)},
        "charts": {k: json.loads(figure.to_json()) for k, figure in drawn.items() if figure},
    }


def weld(data: ReportData) -> NDArray[np.uint32]:
    """For each vertex (V,) the first in the same place: texture seams must not be seen in 3D."""
    heads = [data.true.head] if data.true is not None else []
    heads += [s.head for s in data.systems if s.head is not None]
    if not heads:
        return np.arange(len(data.colours), dtype=np.uint32)
    places = np.round(heads[-1].motion.mean.astype(np.float64), 4)
    _, first, same = np.unique(places, axis=0, return_index=True, return_inverse=True)
    return np.asarray(first[same.ravel()], np.uint32)


def _heads(data: ReportData) -> list[dict[str, Any]]:
    """The true head first, then those of the systems."""
    told = []
    if data.true is not None:
        told.append(_head("truth", colours.TRUTH, data.true.head, data.played, None, truth=True))
    for number, system in enumerate(data.systems):
        if system.head is not None:
            colour = colours.system_colour(number)
            told.append(_head(system.name, colour, system.head, data.played, system.error_map))
    return told


def _head(
    name: str,
    colour: str,
    head: Head,
    played: int,
    error_map: FloatArray | None,
    *,
    truth: bool = False,
) -> dict[str, Any]:
    return {
        "name": name,
        "colour": colour,
        "truth": truth,
        "motion": packed_motion(head.motion),
        "rotations": _floats(head.rotations, played),
        "translations": _floats(head.translations, played),
        "map": None if error_map is None else packed(error_map.astype(np.float32)),
    }


def _contours(data: ReportData) -> list[dict[str, Any]]:
    """Contours of the lips: the true ones, then those of the systems that have them."""
    return [
        {
            "name": name,
            "colour": colour,
            "truth": colour == colours.TRUTH_ON_PICTURES,
            "loops": [packed(loop[: data.played].astype(np.float32)) for loop in loops.values()],
        }
        for name, colour, loops in sections.contours(data)
    ]


def _floats(values: NDArray[Any] | None, played: int) -> dict[str, Any] | None:
    return None if values is None else packed(values[:played].astype(np.float32))


def _text(name: str) -> str:
    return (files(__package__) / _WEB / name).read_text(encoding="utf-8")


def _script(name: str) -> str:
    return f"<script>{_closed(_text(name))}</script>"


def _closed(text: str) -> str:
    """A script that cannot end its element early."""
    return text.replace("</script", "<\\/script")
