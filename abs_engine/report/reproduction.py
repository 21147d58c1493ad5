"""The parts that pages of all reproduced papers share: look, tables and figures."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from typing import Any

from abs_engine.core.provenance import caution

_STYLE = """
body { font: 16px/1.5 sans-serif; max-width: 1000px; margin: 2em auto; padding: 0 1em; color: #222 }
img { max-width: 100%; display: block } figure { margin: 1.5em 0 } figcaption { color: #555 }
table { border-collapse: collapse; margin: .7em 0 }
th, td { border-bottom: 1px solid #ddd; padding: 2px 1.2em 2px 0; text-align: left }
th { font-weight: normal; color: #555 } tr.missed td:last-child { color: #b00020 }
td, th { vertical-align: top } td:first-child, td:nth-child(3) { white-space: nowrap }
details { margin: .7em 0 } code { font-size: 90% }
"""
MISSED = "not met"
"""A row whose last cell begins so is marked."""


def page(title: str, heading: str, body: str, results: Mapping[str, Any]) -> str:
    """A whole page; the title and the heading are text, the body is HTML.

    Its first line says if figures of these results, by their commit, may not be published.
    """
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>
<style>{_STYLE}</style></head><body>
{cautioned(results)}<h1>{html.escape(heading)}</h1>
{body}
<p>All numbers: <a href="results.json">results.json</a>.</p>
</body></html>
"""


def cautioned(results: Mapping[str, Any]) -> str:
    """Why figures may not be published, as HTML; nothing where they may."""
    why = caution(results)
    return "" if why is None else f"<p><strong>{html.escape(why)}</strong></p>\n"


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table of texts; see `MISSED`."""
    top = "".join(f"<th>{html.escape(cell)}</th>" for cell in head)
    body = "".join(
        f"<tr{_missed(row[-1])}>{''.join(f'<td>{html.escape(cell)}</td>' for cell in row)}</tr>"
        for row in rows
    )
    return f"<table>{f'<tr>{top}</tr>' if head else ''}{body}</table>"


def _missed(verdict: str) -> str:
    return ' class="missed"' if verdict.startswith(MISSED) else ""


def figures(pictures: Sequence[tuple[str, str]]) -> str:
    """Pictures one below the other, each by its address from the page and its caption."""
    return "".join(_figure(html.escape(at), html.escape(text)) for at, text in pictures)


def _figure(at: str, text: str) -> str:
    return f'<figure><img src="{at}" alt="{text}"><figcaption>{text}</figcaption></figure>\n'
