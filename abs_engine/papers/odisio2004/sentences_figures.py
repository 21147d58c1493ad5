"""Figures 8 and 10: a tracked sentence's evaluations, error and lips over time."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from abs_engine.face.articulated import FaceShape
from abs_engine.papers.odisio2004.sentences_filmed import RATE, Filmed
from abs_engine.papers.odisio2004.sentences_scores import Curves, lip_size

_MARKS = {"tex_lin": "+", "tex_cst": "x", "la_lin": "D", "la_cst": "*"}
"""The paper's."""
_COLOURS = {
    "tex_lin": "tab:blue", "tex_cst": "tab:orange", "la_lin": "tab:green", "la_cst": "tab:red",
}  # fmt: skip
_TITLES = (
    ("evaluations", "evaluations"), ("rms", "RMS 3D\nerror (mm)"), ("width", "lip width\n(mm)"),
    ("aperture", "lip aperture\n(mm)"),
)  # fmt: skip


def curves_figure(shape: FaceShape, filmed: Filmed, of: Mapping[str, Curves]) -> Figure:
    """Figure 8: curves of each model, the truth as a solid line, and what is said when.

    A model's may have fewer frames than were filmed.
    """
    figure = Figure(figsize=(9, 7), layout="constrained")
    axes = figure.subplots(5, 1, sharex=True, height_ratios=(1, 1.4, 1.2, 1.2, 0.3))
    width, aperture = lip_size(shape, filmed.points)
    times = np.arange(len(filmed)) / RATE
    for row, (name, title) in zip(axes[:4], _TITLES, strict=True):
        for model, own in of.items():
            values = getattr(own, name)
            row.plot(
                times[: len(values)], values, _MARKS.get(model, "."), ls="-", lw=0.4, ms=4,
                mfc="none", color=_COLOURS.get(model), label=model,
            )  # fmt: skip
        row.set_ylabel(title, fontsize=8)
        row.tick_params(labelsize=7)
        row.grid(alpha=0.3)
    for row, truth in ((axes[2], width), (axes[3], aperture)):
        row.plot(times, truth, color="black", lw=1.2, label="truth", zorder=0)
    axes[1].set_ylim(0, None)
    handles, names = axes[3].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=len(names), fontsize=8)
    axes[0].set_title(filmed.text, fontsize=9)
    _labels(axes[4], filmed)
    return figure


def _labels(axes: Axes, filmed: Filmed) -> None:
    """Phonemes, IPA, with the closures of the lips shaded."""
    for segment in filmed.utterance.segments:
        if segment.phoneme.manner == "pause" or segment.middle > len(filmed) / RATE:
            continue
        if segment.phoneme.closes_lips:
            axes.axvspan(segment.start, segment.end, color="0.85")
        axes.axvline(segment.start, color="0.6", lw=0.4)
        axes.text(segment.middle, 0.5, segment.phoneme.label, ha="center", va="center", fontsize=8)
    axes.set(yticks=[], ylim=(0, 1), xlabel="seconds", xlim=(0, len(filmed) / RATE))
