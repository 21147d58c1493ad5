"""The report of seed 001 as one HTML page beside its figures."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from typing import Any

from abs_engine.systems.articulatory.models import MODELS
from abs_engine.systems.articulatory.tables import PAPER_TOTAL, PAPER_VARIANCE

Results = Mapping[str, Any]
MISSING = "not measured"
_STYLE = """
body { font: 16px/1.5 sans-serif; max-width: 1000px; margin: 2em auto; padding: 0 1em; color: #222 }
img { max-width: 100%; display: block } figure { margin: 1.5em 0 } figcaption { color: #555 }
table { border-collapse: collapse; margin: .7em 0 }
th, td { border-bottom: 1px solid #ddd; padding: 2px 1.2em 2px 0; text-align: left }
th { font-weight: normal; color: #555 }
"""
GOALS = (
    ("variance.total", "variance held by seven parameters", 0.9629, True),
    ("model_error_mm_median", "model error, median over visemes, mm", 0.5, False),
    ("visemes.tex_lin.median_mm", "visemes, tex_lin, beads, mm", 0.5, False),
    ("visemes.la_lin.median_mm", "visemes, la_lin, beads, mm", 0.5, False),
    ("visemes_bare.tex_lin.median_mm", "visemes, tex_lin, bare face, mm", 0.5, False),
    ("visemes_bare.la_lin.median_mm", "visemes, la_lin, bare face, mm", 0.5, False),
    ("sentences.tex_lin.rms_mm", "sentences, tex_lin, mm", 0.4, False),
    ("sentences.la_lin.rms_mm", "sentences, la_lin, mm", 0.8, False),
    ("sentences.tex_lin.evaluations_per_frame", "sentences, evaluations a frame", 300, False),
    ("sentences.tex_lin.closure_precision", "sentences, closures, precision", 0.95, True),
    ("sentences.tex_lin.closure_recall", "sentences, closures, recall", 1.0, True),
    ("teleconference.tex_cst.rms_mm", "teleconference, tex_cst, mm", 2.5, False),
    ("teleconference.la_lin.rms_mm", "teleconference, la_lin, mm", 1.3, False),
)
"""Key of the results, name, bound, and whether the number is to be at least that."""


def number(results: Results, key: str) -> float | None:
    """A number of nested results by its dotted key, or None."""
    value: Any = results
    for part in key.split("."):
        value = value.get(part) if isinstance(value, Mapping) else None
    return float(value) if isinstance(value, int | float) else None


def goal_rows(results: Results) -> list[tuple[str, str, str, str]]:
    """What was aimed at: name, measured, bound, and by how much it is met or missed."""
    rows = []
    for key, name, bound, least in GOALS:
        value = number(results, key)
        aim = f"{'≥' if least else '≤'} {bound:g}"
        if value is None:
            rows.append((name, MISSING, aim, ""))
            continue
        ahead = value - bound if least else bound - value
        verdict = f"{'met' if ahead >= 0 else 'not met'}, by {abs(ahead):.3g}"
        rows.append((name, f"{value:.4g}", aim, verdict))
    return rows


def score_lines(results: Results) -> list[str]:
    """The main numbers for a terminal."""
    lines = [f"{'':40}{'here':>14}  goal"]
    lines += [f"{a:40}{b:>14}  {c:10}{d}".rstrip() for a, b, c, d in goal_rows(results)]
    return lines


def reproduction_page(results: Results, figures: Sequence[tuple[str, str]]) -> str:
    """The page; what the results lack is told as not measured.

    Parameters
    ----------
    results : mapping
        What ``results.json`` holds.
    figures : sequence of (str, str)
        Address of a picture from the page, and its caption.
    """
    pictures = "".join(
        f'<figure><img src="{html.escape(a)}" alt="{html.escape(c)}">'
        f"<figcaption>{html.escape(c)}</figcaption></figure>\n"
        for a, c in figures
    )
    made = [(k, str(results.get(k))) for k in ("command", "person", "seed", "seconds", "renderer")]
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Seed 001 reproduced</title>
<style>{_STYLE}</style></head><body>
<h1>Shape and appearance models of talking faces, reproduced</h1>
{_table((), made)}
<p>Errors are those of the 275 points from where they were filmed, in head coordinates: what the
seven parameters cannot follow is in them. Visemes are those that appearance was not learned from,
found from the neutral posture with the head's motion known, as in the paper.</p>
<h2>At a glance</h2>
{_table(("", "here", "goal", ""), goal_rows(results))}
<h2>Table 1: variance</h2>
{_variance(results)}
<h2>Visemes the models were not learned from</h2>
{_visemes(results)}
<h2>The search, all 13 parameters, at equal numbers of evaluations</h2>
{_rows(results.get("search_table"))}
<h2>The stopping rule, measured on visemes kept out of training and tests</h2>
{_rows(results.get("stopping"))}
<h2>Figures</h2>
{pictures}
<p>All numbers: <a href="results.json">results.json</a>.</p>
</body></html>
"""


def _variance(results: Results) -> str:
    papers = {**PAPER_VARIANCE, "total": PAPER_TOTAL}
    rows = []
    for name, paper in papers.items():
        value = number(results, f"variance.{name}")
        rows.append((name, MISSING if value is None else f"{value:.2%}", f"{paper:.2%}"))
    return _table(("parameter", "here", "paper"), rows)


def _visemes(results: Results) -> str:
    columns = ("median_mm", "lips_median_mm", "worst_mm", "below_half_mm", "evaluations")
    rows = []
    for key, what in (("visemes", "beads"), ("visemes_bare", "bare")):
        for name in (*MODELS, "neutral"):
            values = [number(results, f"{key}.{name}.{c}") for c in columns]
            rows.append((what, name, *(MISSING if v is None else f"{v:.3g}" for v in values)))
    head = ("face", "model", "median, mm", "lips, mm", "worst, mm", "share ≤ 0.5 mm", "evaluations")
    return _table(head, rows)


def _rows(found: object) -> str:
    if not isinstance(found, Sequence) or not found:
        return f"<p>{MISSING.capitalize()}.</p>"
    rows = [[v if isinstance(v, str) else f"{v:.3g}" for v in row.values()] for row in found]
    return _table(tuple(found[0]), rows)


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    top = "".join(f"<th>{html.escape(cell)}</th>" for cell in head)
    body = "".join(
        f"<tr>{''.join(f'<td>{html.escape(cell)}</td>' for cell in row)}</tr>" for row in rows
    )
    return f"<table>{f'<tr>{top}</tr>' if head else ''}{body}</table>"
