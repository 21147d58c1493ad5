"""Legends as pictures of their own, to stand beside what they explain."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from abs_engine.core.arrays import BoolArray, FloatArray, Image
from abs_engine.report.drawing.palette import paint_flow, paint_normals

DPI = 100
FONT = 9.5  # points; at 100 dots an inch the height of the captions


def colour_bar(colours: Image, limits: tuple[float, float], text: str, height: int) -> Image:
    """A colour bar with its ticks and what it means, (height, W, 3) uint8 RGB."""
    figure = _figure(96, height)
    axes = figure.add_axes((0.08, 0.08, 0.2, 0.84))
    scale: Colormap = ListedColormap(colours / 255.0)
    bar = figure.colorbar(ScalarMappable(Normalize(*limits), scale), cax=axes)
    bar.set_label(text, fontsize=FONT)
    bar.ax.tick_params(labelsize=FONT)
    bar.outline.set_linewidth(0.6)
    return _pixels(figure)


def swatches(names: Sequence[str], colours: Image, height: int) -> Image:
    """Names beside their colours, (height, W, 3) uint8 RGB."""
    figure = _figure(136, height)
    patches = [
        Patch(facecolor=row / 255.0, edgecolor="0.4", linewidth=0.5, label=name.replace("_", " "))
        for name, row in zip(names, colours, strict=True)
    ]
    figure.legend(handles=patches, loc="center left", fontsize=FONT, frameon=False)
    return _pixels(figure)


def _disc() -> tuple[FloatArray, FloatArray, BoolArray]:
    """Coordinates x and y of a small square of pixels, and which lie in the unit circle."""
    x, y = np.meshgrid(*[np.linspace(-1.02, 1.02, 96)] * 2)
    return x, y, x * x + y * y <= 1


def normals_ball(height: int) -> Image:
    """Legend of the colours of normals: a ball seen from the front, (height, W, 3) uint8 RGB."""
    x, y, inside = _disc()
    z = -np.sqrt(np.where(inside, 1 - x * x - y * y, 0))
    ball = paint_normals(np.stack([x, y, z], axis=-1), inside)
    return _explained(
        ball, "normals of a ball:\nred to the right,\ngreen up, blue to\nthe camera", height
    )


def flow_wheel(largest: float, height: int) -> Image:
    """Legend of the colours of flow: a wheel whose rim is `largest` pixels a frame."""
    x, y, inside = _disc()
    wheel = paint_flow(np.stack([x, y], axis=-1) * largest, largest, inside)
    return _explained(
        wheel, f"flow to the next\nframe; the rim is\n{largest:.3g} pixels\nor more", height
    )


def _explained(picture: Image, text: str, height: int) -> Image:
    """A small picture with some lines below it, in the middle of the height."""
    high, wide = picture.shape[:2]
    width, height = wide + 40, max(height, high + 84)
    figure = _figure(width, height)
    top = 0.5 + (high + 64) / 2 / height
    axes = figure.add_axes((20 / width, top - high / height, wide / width, high / height))
    axes.imshow(picture)
    axes.axis("off")
    figure.text(0.5, top - (high + 8) / height, text, fontsize=FONT, ha="center", va="top")
    return _pixels(figure)


def _figure(width: int, height: int) -> Figure:
    return Figure((width / DPI, height / DPI), dpi=DPI)


def _pixels(figure: Figure) -> Image:
    """The figure drawn, (H, W, 3) uint8 RGB."""
    raw = BytesIO()
    figure.savefig(raw, format="rgba", dpi=DPI)
    width, height = (round(DPI * inches) for inches in figure.get_size_inches())
    return np.frombuffer(raw.getvalue(), np.uint8).reshape(height, width, 4)[..., :3].copy()
