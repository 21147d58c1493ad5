"""The top of the page: title, legend, and the numbers of the first glance."""

from __future__ import annotations

from abs_engine.evaluate.catalogue import BY_KEY
from abs_engine.evaluate.score import Score
from abs_engine.evaluate.score_table import shown, shown_unit
from abs_engine.report.data import ReportData
from abs_engine.report.document import safe
from abs_engine.report.drawing import colours
from abs_engine.report.sections import key

CARDS = (
    ("frames_lost",),
    ("lip_landmarks_rms_head_mm", "lip_points_rms_head_mm", "lips_rms_px"),
    ("lips_rms_head_mm", "landmarks_rms_head_mm"),
    ("face_rms_head_mm", "landmarks_rms_px"),
    ("aperture_rms_mm",),
    ("closure_recall_events",),
    ("head_angle_rms_deg",),
)
"""Metrics of the first glance; of each group the first that there is."""


def heading(data: ReportData) -> str:
    """Title, legend and the numbers of the first glance."""
    caution = f'<p class="warning">{safe(data.caution)}</p>' if data.caution else ""
    return f"""<header>{caution}<h1>{safe(data.title)}</h1>
<p class="soft">{safe(data.subtitle)}</p>{_views(data)}
{key(data)}</header>{_cards(data)}"""


def _views(data: ReportData) -> str:
    """Clip and camera that are shown, and the others that exist."""
    if not data.view:
        return ""
    clip, camera = (safe(name) for name in data.view.split("/"))
    others = f"; also in the dataset: {safe(', '.join(data.others))}" if data.others else ""
    return f'<p class="soft">Clip <b>{clip}</b> by camera <b>{camera}</b>{others}.</p>'


def _cards(data: ReportData) -> str:
    """For each system the numbers of the first glance."""
    lines = []
    for number, system in enumerate(data.systems):
        found = ([key for key in group if key in system.scores] for group in CARDS)
        keys = [group[0] for group in found if group]
        if not keys and not system.notes:
            continue
        title = f"<h3>{safe(system.name)}</h3>" if len(data.systems) > 1 else ""
        cards = "".join(_card(key, system.scores[key], number) for key in keys)
        notes = "".join(f'<p class="warning">{safe(_sentence(note))}</p>' for note in system.notes)
        lines.append(f'{title}<div class="cards">{cards}</div>{notes}')
    return "".join(lines)


def _sentence(note: str) -> str:
    """A note with its first letter large and a mark at its end."""
    return note[:1].upper() + note[1:] + ("" if note.endswith(("?", ".", "!")) else ".")


def _card(key: str, score: Score, number: int) -> str:
    metric = BY_KEY[key]
    value, sure = shown(metric, score)
    unit = f" {shown_unit(metric)}" if metric.unit else ""
    return (
        f'<div class="card" style="border-color:{colours.system_colour(number)}">'
        f"<b>{value}{unit}</b><small>{safe(metric.label)}<br>{sure}</small></div>"
    )
