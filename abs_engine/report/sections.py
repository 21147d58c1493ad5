"""The parts of the page below its top, as HTML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from abs_engine.core.arrays import FloatArray
from abs_engine.evaluate.catalogue import Metric
from abs_engine.evaluate.score_table import IN_BRACKETS, shown, shown_unit, used
from abs_engine.report.data import ReportData, Rows, System
from abs_engine.report.document import safe
from abs_engine.report.drawing import colours
from abs_engine.report.embed import text64
from abs_engine.report.quantities import SHARE

TUNING = "tuning: "  # begins the names of the numbers that steer a run
SCALE_ENDS = (0.5, 1.0, 2.0, 4.0, 10.0, 20.0)  # mm
_NO_WEBGL = (
    '<p class="warning no-webgl" hidden>This browser gives the page no WebGL 2, which the 3D '
    "pictures need.</p>"
)


def key(data: ReportData, *, of_errors: bool = False) -> str:
    """The legend of all curves, to be read beside each chart; the truth has no errors."""
    true = data.true is not None and not of_errors
    named = [("truth", colours.truth_stroke())] if true else []
    named += [(s.name, colours.system_stroke(k)) for k, s in enumerate(data.systems)]
    items = "".join(f"<li>{swatch(stroke)}{safe(name)}</li>" for name, stroke in named)
    if data.true is not None:
        items += '<li><span class="swatch area" style="background:#dddde3"></span>'
        items += "lips truly closed</li>"
    return f'<ul class="legend">{items}</ul>'


def swatch(stroke: colours.Stroke) -> str:
    """A piece of a line, as it is drawn."""
    gaps = " ".join(map(str, stroke.gaps)) or "none"
    line = (
        f'<line x1="0" y1="50%" x2="44" y2="50%" stroke="{stroke.colour}" '
        f'stroke-width="{stroke.width:g}" stroke-dasharray="{gaps}"/>'
    )
    return f'<svg class="swatch" width="44" height="8" aria-hidden="true">{line}</svg>'


def player(data: ReportData) -> str:
    """The video beside the heads, and what controls them."""
    if data.film is None and not _heads(data):
        return ""
    film = (
        '<div class="film"><video muted playsinline></video><canvas></canvas></div>'
        if data.film is not None
        else ""
    )
    stage = '<div class="stage"><canvas></canvas></div>' if _heads(data) else ""
    cut = (
        f'<p class="soft">The first {data.played} of {len(data.times)} frames.</p>'
        if data.played < len(data.times)
        else ""
    )
    return f"""<section><h2>Video and heads</h2>{cut}
<div class="player">{film}{stage}</div>
<div class="bar"><button id="play">Play</button>
<input type="range" id="scrub" min="0" max="{data.played - 1}" value="0" aria-label="frame">
<span id="where"></span>
<label>speed <select id="speed"><option value="1">1</option><option value="0.5">1/2</option>
<option value="0.25">1/4</option><option value="0.1">1/10</option></select></label></div>
{_contour_boxes(data)}{_head_controls(data)}{_NO_WEBGL if stage else ""}</section>"""


def lip_curves(data: ReportData, charts: Mapping[str, Any]) -> str:
    """The lip curves."""
    if "lips" not in charts:
        return ""
    about = (
        "Black: truth. Phonemes above. Grey: the lips truly closed. A band is a 95 % interval."
        if data.true is not None
        else "As tracked. A band is a 95 % interval."
    )
    return f"""<section><h2>Lip curves</h2><p>{about} <span class="soft hint">Drag to enlarge,
double-click for the whole clip, click to go to a frame.</span></p>
{key(data)}<div class="chart" id="chart-lips"></div></section>"""


def sureness(data: ReportData, charts: Mapping[str, Any]) -> str:
    """Section on the systems' uncertainty, frame by frame."""
    if "sureness" not in charts:
        return ""
    return f"""<section><h2>How sure it is</h2><p>Score: how well the drawing explains the picture
around the mouth. ±: half of the 95 % interval. Off landmarks: how far the lips lie from those that
the landmark network sees. Gaps are frames without numbers.</p>
{key(data)}<div class="chart" id="chart-sureness"></div></section>"""


def errors(data: ReportData, charts: Mapping[str, Any]) -> str:
    """Errors over time, and their spread."""
    if "errors" not in charts:
        return ""
    names = ", ".join(q.label for q in data.errors if q.unit != SHARE)
    shares = (
        " 95 % intervals: which share of the coordinates they hold."
        if any(q.unit == SHARE for q in data.errors)
        else ""
    )
    return f"""<section><h2>Errors</h2><p>In each frame: {safe(names)}; for points the root mean
square distance to the truth.{shares} Gaps are lost frames.</p>
{key(data, of_errors=True)}<div class="chart" id="chart-errors"></div>
<h3>Their spread over the frames</h3>
<p>Box: quartiles and median. Dashed: mean. Whiskers: the farthest values within 1.5 times the
box's height; dots lie beyond.</p>
<div class="chart" id="chart-boxes"></div></section>"""


def error_maps(data: ReportData, end: float) -> str:
    """Errors painted on the face, with their scale."""
    if not any(s.error_map is not None and s.head is not None for s in data.systems):
        return ""
    steps = ",".join(f"rgb({r},{g},{b})" for r, g, b in colours.HEAT_COLOURS[::16])
    ticks = "".join(f"<span>{end * k / 4:g}</span>" for k in range(4))
    return f"""<section><h2>Error on the face</h2>
<p>RMS error of each vertex over the tracked frames, head coordinates, painted on the true head at
rest. <span class="soft hint">Drag to turn.</span></p>{_NO_WEBGL}
<div class="maps"><canvas></canvas></div>
<div class="scale"><div><div class="ramp" style="background:linear-gradient(90deg,{steps})"></div>
<div class="ticks">{ticks}<span>{end:g}+</span></div></div><span>mm</span>
<label class="hint">scale ends at <select id="scale">{_ends(end)}</select> mm</label></div>
</section>"""


def worst(data: ReportData) -> str:
    """The frames of the largest errors."""
    parts = []
    for number, system in enumerate(data.systems):
        if system.worst:
            name = f'<h3 style="color:{colours.system_colour(number)}">{safe(system.name)}</h3>'
            parts.append(f'{name}<div class="worst">{"".join(_figures(system, data.played))}</div>')
    if not parts:
        return ""
    return f"""<section><h2>Worst frames</h2><p>White: the true contours of the lips.
Coloured: the tracked ones. <span class="soft hint">Click to see the frame
above.</span></p>{"".join(parts)}</section>"""


def scores(data: ReportData) -> str:
    """The table of scores and, folded, what they mean."""
    metrics = used(system.scores for system in data.systems)
    if not metrics:
        return ""
    head = "".join(f"<th>{safe(s.name)}</th>" for s in data.systems)
    rows = "".join(_score_row(metric, data) for metric in metrics)
    means = "".join(
        f"<tr><th>{safe(m.label.strip())}</th><td>{safe(m.definition)}</td></tr>" for m in metrics
    )
    return f"""<section><h2>Scores</h2>
<p>{IN_BRACKETS}</p>
<div class="wide"><table class="scores"><thead><tr><th></th><th></th>{head}</tr></thead>
<tbody>{rows}</tbody></table></div>
<details><summary>What the numbers mean</summary><table>{means}</table></details></section>"""


def facts(data: ReportData) -> str:
    """Section on where everything comes from."""
    blocks = [_facts(title, rows) for title, rows in data.facts.items() if rows]
    blocks += [_facts(f"System: {s.name}", s.facts) for s in data.systems if s.facts]
    return f"<section><h2>How it was made</h2>{''.join(blocks)}</section>" if blocks else ""


def contours(data: ReportData) -> list[tuple[str, colours.Stroke, Mapping[str, FloatArray]]]:
    """Name, stroke and contours: of the truth, then of the systems that have them."""
    found = []
    if data.true is not None and data.true.contours:
        found.append(("truth", colours.picture_stroke(None), data.true.contours))
    for number, system in enumerate(data.systems):
        if system.contours:
            found.append((system.name, colours.picture_stroke(number), system.contours))
    return found


def _ends(end: float) -> str:
    """Possible ends of the scale of errors."""
    return "".join(
        f'<option value="{k:g}"{" selected" if k == end else ""}>{k:g}</option>'
        for k in sorted({*SCALE_ENDS, end})
    )


def _heads(data: ReportData) -> bool:
    return data.true is not None or any(s.head is not None for s in data.systems)


def _contour_boxes(data: ReportData) -> str:
    shown = contours(data)
    if data.film is None or not shown:
        return ""
    boxes = "".join(
        f'<label><input type="checkbox" data-contour="{k}" checked> {swatch(stroke)} '
        f"{safe(name)}</label>"
        for k, (name, stroke, _) in enumerate(shown)
    )
    return f'<div class="bar"><span class="soft">lips on the video:</span>{boxes}</div>'


def _head_controls(data: ReportData) -> str:
    if not _heads(data):
        return ""
    modes = [("beside", "side by side")]
    if data.true is not None and any(s.head is not None for s in data.systems):
        modes += [("over", "over the truth"), ("error", "error of this frame")]
    heads = sum(s.head is not None for s in data.systems) + (data.true is not None)
    buttons = (
        ""
        if heads < 2
        else "".join(
            f'<button data-mode="{mode}" {chosen}>{text}</button>'
            for (mode, text), chosen in zip(modes, ("class=chosen", "", ""), strict=False)
        )
    )
    return f"""<div class="bar"><span>{buttons}</span>
<span><button data-yaw="0">front</button><button data-yaw="-0.8">three quarters</button><button
data-yaw="-1.5708">side</button></span>
<label><input type="checkbox" id="close"> mouth only</label>
<label><input type="checkbox" id="motion"> head motion</label>
<span class="soft">drag to turn, Ctrl + wheel to enlarge</span></div>"""


def _figures(system: System, played: int) -> list[str]:
    out = []
    for one in system.worst:
        seek = f' data-frame="{one.frame}"' if one.frame < played else ""
        source = f"data:image/webp;base64,{text64(one.picture)}"
        out.append(
            f'<figure><img src="{source}" alt="mouth in frame {one.frame}"{seek}>'
            f"<figcaption>{safe(one.text)}</figcaption></figure>"
        )
    return out


def _score_row(metric: Metric, data: ReportData) -> str:
    cells = []
    for system in data.systems:
        value, sure = shown(metric, system.scores.get(metric.key))
        cells.append(f'<td class="number">{value} <span class="between">{sure}</span></td>')
    unit = safe(shown_unit(metric))
    return f'<tr><th>{safe(metric.label)}</th><td class="soft">{unit}</td>{"".join(cells)}</tr>'


def _facts(title: str, rows: Rows) -> str:
    tuning = [row for row in rows if row[0].startswith(TUNING)]
    shown = _fact_table([row for row in rows if row not in tuning])
    if tuning:
        summary = f"<summary>Numbers that steer results ({len(tuning)})</summary>"
        shown += f"<details>{summary}{_fact_table(tuning)}</details>"
    return f"<h3>{safe(title)}</h3>{shown}"


def _fact_table(rows: Sequence[tuple[str, str]]) -> str:
    lines = "".join(
        f"<tr><th>{safe(name)}</th><td><code>{safe(text)}</code></td></tr>" for name, text in rows
    )
    return f'<table class="facts">{lines}</table>'
