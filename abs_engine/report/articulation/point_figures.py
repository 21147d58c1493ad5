"""Nomograms of a model that has points and no head: how far each parameter moves each point."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.face.shape.articulatory_model import ArticulatoryModel
from abs_engine.report.drawing.figure import plain

REACH = 2.0
"""Standard deviations by which a parameter moves to either side."""
_VIEWS = (("front", 0), ("side", 2))
"""Name, and the coordinate that goes to the right: x to the subject's left, or z forward."""
_OWN, _OTHER = "tab:red", "0.45"
_ABREAST, _WIDE, _MARGIN = 4, 2.6, 1.08


def point_nomograms(model: ArticulatoryModel) -> Figure:
    """The elementary movements of a model's points, each from the front and from the side.

    Each point is drawn as its way from -2 to +2 standard deviations of one parameter, with a dot
    at the end; those that the parameter is made of are red.
    """
    count = len(model.parameters)
    across = min(count, _ABREAST)
    bands = -(-count // across)
    low, high = _extent(model)
    heights = (high - low)[1] / (high - low)[[0, 2]].max()
    size = _WIDE * across, 2 * bands * (_WIDE * heights + 0.4) + 0.3
    figure = Figure(figsize=size, layout="constrained")
    grid = figure.subplots(2 * bands, across, squeeze=False)
    for axes in grid.flat:
        axes.set_axis_off()
    for k, predictor in enumerate(model.predictors):
        own = np.zeros(len(model.names), np.bool_)
        own[predictor.columns(model.names, model.groups) // 3] = True
        ends = model.mean + REACH * np.stack([-model.modes[k], model.modes[k]])
        for row, (view, right) in enumerate(_VIEWS):
            axes = grid[2 * (k // across) + row, k % across]
            _draw(axes, ends[..., [right, 1]], own)
            axes.set(xlim=(low[right], high[right]), ylim=(low[1], high[1]), aspect="equal")
            named = f"{plain(predictor.name)}, {100 * model.variance[k]:.1f} %"
            axes.set_title(view if row else named, fontsize=9)
    return figure


def _extent(model: ArticulatoryModel) -> tuple[FloatArray, FloatArray]:
    """Lower and upper corner (3,) of what all movements reach, with a margin."""
    reached = model.mean + REACH * np.concatenate([-model.modes, model.modes])
    low, high = reached.min(axis=(0, 1)), reached.max(axis=(0, 1))
    middle, half = (low + high) / 2, _MARGIN * (high - low) / 2
    half = np.maximum(half, 1e-3 + 0.05 * half.max())  # points in one plane have no depth
    return middle - half, middle + half


def _draw(axes: Axes, ends: FloatArray, own: BoolArray) -> None:
    """Ways (2, N, 2) of points, from the first to the second."""
    for chosen, colour in ((~own, _OTHER), (own, _OWN)):
        ways = ends[:, chosen].transpose(1, 0, 2)
        axes.add_collection(LineCollection(list(ways), colors=colour, linewidths=0.8))
        axes.plot(*ways[:, 1].T, ".", color=colour, markersize=1.8)
