"""The page: one HTML file that opens from disk and needs nothing from outside."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray
from plotly.offline import get_plotlyjs

from abs_engine.core.threads import kept
from abs_engine.report import charts, glance, sections
from abs_engine.report.data import Head, ReportData
from abs_engine.report.document import document, web
from abs_engine.report.drawing import colours
from abs_engine.report.embed import Store, deflated, json_bytes

_SCRIPTS = ("arrays.js", "heads.js", "stage.js", "player.js", "main.js")

# What a browser may load for the page: nothing but what is in it.
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; media-src data: blob:; font-src data:"
)
_LIMITS = """<noscript><p class="warning">This page draws its charts with JavaScript; allow it to
run.</p></noscript>
<p class="warning too-old" hidden>This browser cannot inflate what the page holds (it has no
DecompressionStream); open it in a newer one.</p>
"""


def report_page(data: ReportData) -> str:
    """The whole page as HTML."""
    store = Store()
    told = page_data(data, store)
    body = "\n".join(
        part
        for part in (
            glance.heading(data),
            sections.player(data),
            sections.lip_curves(data, told["charts"]),
            sections.sureness(data, told["charts"]),
            sections.errors(data, told["charts"]),
            sections.error_maps(data, told["ramp"]["end"]),
            sections.worst(data),
            sections.scores(data),
            sections.facts(data),
        )
        if part
    )
    # no script can end its element early
    sources = (web(name).replace("</script", "<\\/script") for name in _SCRIPTS)
    scripts = "\n".join(f"<script>{source}</script>" for source in sources)
    parts = {
        "data": deflated(json_bytes(told)),
        "arrays": deflated(store.content),
        "plotly": _plotly(),
    }
    deflates = "\n".join(
        f'<script type="text/plain" id="{name}">{content}</script>'
        for name, content in parts.items()
    )
    return document(
        data.title,
        _LIMITS + body,
        head=f'\n<meta http-equiv="Content-Security-Policy" content="{_POLICY}">',
        style=web("page.css"),
        end=f"{deflates}\n{scripts}\n",
    )


@kept
def _plotly() -> str:
    """Plotly's script, which is the same on every page, deflated."""
    return deflated(get_plotlyjs().encode("utf-8"))


def page_data(data: ReportData, store: Store) -> dict[str, Any]:
    """Data for the page's scripts, as JSON values; arrays go to the store."""
    area = slice(None) if data.area is None else data.area
    maps = [s.error_map[area] for s in data.systems if s.error_map is not None]
    drawn = {
        "lips": charts.lip_chart(data),
        "errors": charts.frame_chart(data, "errors", data.errors),
        "sureness": charts.frame_chart(data, "sureness", data.sureness),
        "boxes": charts.box_chart(data),
    }
    said = data.true.said if data.true is not None else ()
    return {
        "rate": data.rate,
        "times": data.times.tolist(),
        "played": data.played,
        "vertices": len(data.colours),
        "focus": list(data.focus),
        "weld": store.add(weld(data), 1),
        "faces": store.add(data.faces.astype(np.uint32).ravel(), 3),
        "colours": store.add(data.colours, 3),
        "heads": _heads(data, store),
        "contours": _contours(data, store),
        "film": None
        if data.film is None
        else {
            "data": store.add(np.frombuffer(data.film.content, np.uint8)),
            "size": list(data.film.size),
        },
        "said": [[s.label, s.start, s.end] for s in said],
        "ramp": {"colours": store.add(colours.HEAT_COLOURS), "end": colours.scale_end(maps)},
        "charts": {k: json.loads(figure.to_json()) for k, figure in drawn.items() if figure},
    }


def weld(data: ReportData) -> NDArray[np.uint32]:
    """For each vertex (V,) the first in the same place: texture seams must not be seen in 3D."""
    heads = [data.true.head] if data.true is not None else []
    heads += [s.head for s in data.systems if s.head is not None]
    if not heads:
        return np.arange(len(data.colours), dtype=np.uint32)
    return welded(heads[-1].motion.mean)


def welded(points: NDArray[np.floating[Any]]) -> NDArray[np.uint32]:
    """For each of some points (V, 3), mm, the first in the same place, (V,)."""
    places = np.round(points.astype(np.float64), 4)
    _, first, same = np.unique(places, axis=0, return_index=True, return_inverse=True)
    return np.asarray(first[same.ravel()], np.uint32)


def _heads(data: ReportData, store: Store) -> list[dict[str, Any]]:
    """The true head first, then those of the systems."""
    told = []
    if data.true is not None:
        told.append({"name": "truth", "colour": colours.TRUTH, "truth": True, "map": None})
        told[-1] |= _moved(data.true.head, data.played, store)
    for number, system in enumerate(data.systems):
        if system.head is not None:
            errors = system.error_map
            told.append(
                {
                    "name": system.name,
                    "colour": colours.system_colour(number),
                    "truth": False,
                    "map": None if errors is None else store.add_steps(errors, 1),
                    **_moved(system.head, data.played, store),
                }
            )
    return told


def _moved(head: Head, played: int, store: Store) -> dict[str, Any]:
    """Motion of a head."""

    def kept(values: NDArray[Any] | None) -> dict[str, Any] | None:
        return None if values is None else store.add(values[:played].astype(np.float32))

    return {
        "motion": store.add_motion(head.motion),
        "rotations": kept(head.rotations),
        "translations": kept(head.translations),
    }


def _contours(data: ReportData, store: Store) -> list[dict[str, Any]]:
    """Contours of the lips: the true ones, then those of the systems that have them."""
    return [
        {
            "name": name,
            "stroke": {"colour": stroke.colour, "width": stroke.width, "dash": stroke.gaps},
            "loops": [
                store.add_steps(loop[: data.played], 2 * loop.shape[1]) for loop in loops.values()
            ],
        }
        for name, stroke, loops in sections.contours(data)
    ]
