"""The error of the lips frame by frame, a line for each driver, as SVG."""

from __future__ import annotations

import html
import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from abs_engine.report.colours import SYSTEMS

FloatArray = NDArray[np.float64]
WIDTH, HEIGHT = 900, 300
_LEFT, _RIGHT, _TOP, _BOTTOM = 52, 14, 34, 40  # px around the axes
_STEPS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0)
_MARKS = 8  # on an axis, at most
_GREY = "#666"


def error_plot(
    series: Mapping[str, Sequence[float]],
    goal: float | None = None,
    breaks: Mapping[int, str] | None = None,
) -> str:
    """Errors over the frames.

    Parameters
    ----------
    series : mapping of str to sequence of float, mm
        By what made them; what is not finite is a gap.
    goal : float, mm, optional
        Drawn as a dashed line.
    breaks : mapping of int to str, optional
        Where in the frames another view begins, and its name.

    Returns
    -------
    str
        An SVG document.
    """
    known = {name: np.asarray(values, np.float64) for name, values in series.items()}
    frames = max((len(v) for v in known.values()), default=0)
    finite = [v[np.isfinite(v)] for v in known.values()]
    top = 1.1 * max((float(v.max()) for v in finite if len(v)), default=1.0)
    axes = _Axes(max(frames - 1, 1), max(top, 1.2 * (goal or 0.0), 0.1))
    parts = [axes.grid(), *(axes.view(at, name) for at, name in (breaks or {}).items())]
    if goal is not None:
        parts.append(axes.goal(goal))
    parts += [axes.line(v, SYSTEMS[k % len(SYSTEMS)]) for k, v in enumerate(known.values())]
    parts.append(_legend({name: _rms(values) for name, values in known.items()}))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" '
        f'viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="12" fill="#222">'
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>{"".join(parts)}</svg>\n'
    )


class _Axes:
    """From frames and mm to pixels of the plot."""

    def __init__(self, last: int, top: float) -> None:
        self.last, self.top = last, top

    def x(self, frame: float) -> float:
        return _LEFT + frame / self.last * (WIDTH - _LEFT - _RIGHT)

    def y(self, error: float) -> float:
        return HEIGHT - _BOTTOM - error / self.top * (HEIGHT - _TOP - _BOTTOM)

    def grid(self) -> str:
        """Both axes with their marks and names."""
        parts = []
        for error in _marks(self.top):
            y, told = self.y(error), f"{error:g}"
            parts.append(_stroke(_LEFT, y, WIDTH - _RIGHT, y, "#e0e0e0"))
            parts.append(_text(_LEFT - 6, y + 4, told, "end"))
        for frame in _marks(self.last, least=1.0):
            x = self.x(frame)
            parts.append(_stroke(x, HEIGHT - _BOTTOM, x, HEIGHT - _BOTTOM + 4, "#999"))
            parts.append(_text(x, HEIGHT - _BOTTOM + 17, f"{frame:g}", "middle"))
        parts.append(_text((_LEFT + WIDTH) / 2, HEIGHT - 6, "frame", "middle"))
        side = f'<g transform="translate(14 {(HEIGHT - _BOTTOM + _TOP) / 2}) rotate(-90)">'
        parts.append(side + _text(0, 0, "lip error, mm", "middle") + "</g>")
        return "".join(parts)

    def view(self, frame: int, name: str) -> str:
        x = self.x(max(frame - 0.5, 0))
        line = _stroke(x, _TOP, x, HEIGHT - _BOTTOM, "#bbb")
        return line + _text(x + 4, _TOP + 11, name, "start", _GREY)

    def goal(self, error: float) -> str:
        y = self.y(error)
        line = _stroke(_LEFT, y, WIDTH - _RIGHT, y, _GREY, ' stroke-dasharray="5 4"')
        return line + _text(WIDTH - _RIGHT, 18, f"dashed: goal {error:g} mm", "end", _GREY)

    def line(self, values: FloatArray, colour: str) -> str:
        """Frames that follow each other joined, each marked by a dot."""
        seen = [(k, self.x(k), self.y(float(v))) for k, v in enumerate(values) if np.isfinite(v)]
        path, before = [], -2
        for k, x, y in seen:
            path.append(f"{'L' if k == before + 1 else 'M'}{x:.1f} {y:.1f}")
            before = k
        dots = "".join(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2"/>' for _, x, y in seen)
        drawn = f'<path d="{" ".join(path)}" fill="none" stroke="{colour}" stroke-width="1.5"/>'
        return f'{drawn if path else ""}<g fill="{colour}">{dots}</g>'


def _marks(top: float, least: float = 0.0) -> list[float]:
    """Round numbers from 0 to `top`, at least `least` apart."""
    step = next((s for s in _STEPS if s >= least and top / s <= _MARKS), top)
    return [k * step for k in range(math.floor(top / step + 1e-9) + 1)]


def _legend(rms: Mapping[str, float]) -> str:
    """Names beside their colours, with the RMS of each."""
    parts, x = [], float(_LEFT)
    for k, (name, value) in enumerate(rms.items()):
        told = f"{name}, {value:.2f} mm RMS" if math.isfinite(value) else f"{name}, not measured"
        colour = SYSTEMS[k % len(SYSTEMS)]
        parts.append(f'<rect x="{x:.0f}" y="11" width="14" height="4" fill="{colour}"/>')
        parts.append(_text(x + 19, 18, told, "start"))
        x += 19 + 6.7 * len(told) + 22
    return "".join(parts)


def _rms(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(np.sqrt((known**2).mean())) if len(known) else math.nan


def _stroke(x1: float, y1: float, x2: float, y2: float, colour: str, more: str = "") -> str:
    return (
        f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{colour}"{more}/>'
    )


def _text(x: float, y: float, text: str, anchor: str, colour: str = "#222") -> str:
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{colour}">'
        f"{html.escape(text)}</text>"
    )
