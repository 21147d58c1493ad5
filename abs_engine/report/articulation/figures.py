"""Figure 2, boxplots of the direct inversion, and figure 3, nomograms of the parameters."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from abs_engine.core.arrays import Image
from abs_engine.core.scene import Renderer
from abs_engine.face.shape.linear import LinearShape
from abs_engine.io.assets import Speaker
from abs_engine.report.articulation.tables import Box
from abs_engine.report.inspect.body import Body
from abs_engine.report.inspect.sheets import Look, Row, nomogram

DEVIATIONS = (-2.0, -1.0, 0.0, 1.0, 2.0)
"""Standard deviations at which the nomograms are drawn."""
_HALF_MM = 0.5
_FONT = 7


def boxplot_figure(boxes: Sequence[Box], rows: int = 2) -> Figure:
    """Figure 2: a box for each viseme, of the errors at its points; the dot is their RMS.

    They begin with the largest RMS, in as many rows as asked for.
    """
    ordered = sorted(boxes, key=lambda b: -b.rms)
    size = -(-len(ordered) // rows)
    figure = Figure(figsize=(10, 2.4 * rows), layout="constrained")
    top = max(max((b.drawn["whishi"], b.rms, *b.drawn["fliers"])) for b in ordered)
    for k, axes in enumerate(np.atleast_1d(figure.subplots(rows, 1))):
        _draw_row(axes, ordered[k * size : (k + 1) * size])
        axes.set(ylim=(0, 1.05 * top), ylabel="error of a point (mm)", xlim=(-0.7, size - 0.3))
    return figure


def _draw_row(axes: Axes, boxes: Sequence[Box]) -> None:
    if not boxes:
        return
    axes.bxp(
        [b.drawn for b in boxes], positions=range(len(boxes)), widths=0.6, manage_ticks=True,
        flierprops={"marker": "+", "markersize": 2, "markeredgecolor": "0.6"},
        medianprops={"color": "black"}, boxprops={"color": "0.3"},
    )  # fmt: skip
    axes.plot(range(len(boxes)), [b.rms for b in boxes], ".", color="tab:red", markersize=4)
    axes.axhline(_HALF_MM, color="0.8", lw=0.8, zorder=0)
    axes.tick_params(axis="x", labelsize=_FONT, labelrotation=90)
    axes.tick_params(axis="y", labelsize=_FONT)


def nomogram_figure(
    renderer: Renderer,
    speaker: Speaker,
    shape: LinearShape,
    names: Sequence[str],
    *,
    person: str | None = None,
    size: tuple[int, int] = (150, 175),
    turn: float = 0.0,
    crop: str = "head",
    values: Sequence[float] = DEVIATIONS,
) -> Image:
    """Figure 3: a row of heads for each parameter, (H, W, 3) uint8 RGB.

    Parameters
    ----------
    shape : LinearShape
        All vertices of the head, of `dense_head`.
    person : str, optional
        Whose skin is drawn; by default the head is plain.
    size : tuple of int
        Width and height of a head, pixels.
    turn : float
        Degrees to the head's left.
    crop : {"head", "mouth"}
    values : sequence of float
        Standard deviations.
    """
    texture = None if person is None else speaker.texture(person)
    body = Body(speaker, shape.mean.astype(np.float64), texture)
    rows = [
        Row(name, mode.astype(np.float64)) for name, mode in zip(names, shape.modes, strict=True)
    ]
    look = Look(renderer, size, "clay" if person is None else "colour", crop, turn)
    return nomogram(look, body, rows, list(values), "sd")
