"""Files of matplotlib's figures, the same bytes for the same data."""

from __future__ import annotations

import io

import matplotlib
from matplotlib.figure import Figure

_SALT = "abs_engine"  # an SVG's ids are random without


def plain(name: str) -> str:
    """A name as matplotlib writes it, not as mathematics between dollars."""
    return name.replace("$", r"\$")


def figure_bytes(figure: Figure, kind: str = "png") -> bytes:
    """A figure as the bytes of a ``png`` or ``svg`` file."""
    memory = io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": _SALT}):
        figure.savefig(
            memory, format=kind, dpi=150, metadata={"Date": None} if kind == "svg" else None
        )
    return memory.getvalue()
