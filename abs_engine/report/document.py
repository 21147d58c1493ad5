"""HTML documents: the frame, look, tables and figures that all pages of the engine share."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files
from typing import Any

from abs_engine.core.provenance import FIGURES, caution
from abs_engine.core.words import legible

MISSED = "not met"
"""A row whose last cell begins so is marked."""


def document(title: str, body: str, *, head: str = "", style: str = "", end: str = "") -> str:
    """A whole page that needs nothing from outside and is no wider than its screen.

    The title is text; `body`, `head` (more of the page's head) and `end` (behind what is seen) are
    HTML, `style` CSS beside the look that all pages have.
    """
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8">{head}
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{safe(title)}</title>
<style>{web("base.css")}{style}</style></head>
<body><main>
{body}
</main>
{end}</body></html>
"""


def results_page(title: str, heading: str, body: str, results: Mapping[str, Any]) -> str:
    """A page beside its results.json; the title and the heading are text, the body is HTML.

    Its first line says if figures of these results, by their commit, may not be published.
    """
    numbers = '<p>All numbers: <a href="results.json">results.json</a>.</p>'
    return document(
        title, f"{cautioned({FIGURES: results})}<h1>{safe(heading)}</h1>\n{body}\n{numbers}"
    )


def cautioned(sources: Mapping[str, Mapping[str, Any]]) -> str:
    """Reason why a page may not be published, as HTML; nothing where it may. See `caution`."""
    why = caution(sources)
    return "" if why is None else f'<p class="warning">{safe(why)}</p>\n'


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table of texts; see `MISSED`."""
    top = "".join(f"<th>{safe(cell)}</th>" for cell in head)
    body = "".join(
        f"<tr{_missed(row[-1])}>{''.join(f'<td>{safe(cell)}</td>' for cell in row)}</tr>"
        for row in rows
    )
    head_row = f"<thead><tr>{top}</tr></thead>" if head else ""
    return f'<div class="wide"><table>{head_row}<tbody>{body}</tbody></table></div>'


def _missed(verdict: str) -> str:
    return ' class="missed"' if verdict.startswith(MISSED) else ""


def figures(pictures: Sequence[tuple[str, str]]) -> str:
    """Pictures one below the other, each by its address from the page and its caption."""
    named = ((safe(at), safe(text)) for at, text in pictures)
    return "".join(
        f'<figure><img src="{at}" alt="{text}"><figcaption>{text}</figcaption></figure>\n'
        for at, text in named
    )


def safe(text: str) -> str:
    """Text that is no HTML, and can be written in UTF-8."""
    return html.escape(legible(str(text)))


@cache
def web(name: str) -> str:
    """A stylesheet or script of the pages."""
    return (files(__package__) / "web" / name).read_text(encoding="utf-8")
