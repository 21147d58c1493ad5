"""Table 1 beside the paper's, the data of figure 2, and both as values for results.json."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.cbook import boxplot_stats

from abs_engine.core.arrays import FloatArray
from abs_engine.face.shape.articulatory_model import ArticulatoryModel
from abs_engine.learn.articulatory import Build, rms
from abs_engine.report.drawing.figure import plain

PAPER_VARIANCE = {
    "jaw1": 0.1611, "lips1": 0.5010, "lips2": 0.1019, "lips3": 0.0960, "lips4": 0.0672,
    "jaw2": 0.0160, "lar1": 0.0196,
}  # fmt: skip
"""Table 1, fractions."""
PAPER_TOTAL = 0.9629
"""As printed; the rows add up to 0.9628."""


def variance_table(model: ArticulatoryModel) -> list[tuple[str, str, str, str, str]]:
    """Table 1, percent: what each parameter explains, the sum up to it, and both of the paper's.

    The last two are empty where the paper lacks the parameter.
    """
    sums = np.cumsum(list(PAPER_VARIANCE.values()))
    sums[-1] = PAPER_TOTAL
    paper = {
        name: (_percent(share), _percent(sum_))
        for (name, share), sum_ in zip(PAPER_VARIANCE.items(), sums.tolist(), strict=True)
    }
    shares = zip(model.parameters, model.variance, np.cumsum(model.variance), strict=True)
    return [
        (name, _percent(share), _percent(sum_), *paper.get(name, ("", "")))
        for name, share, sum_ in shares
    ]


def _percent(share: float) -> str:
    return f"{100 * float(share):.2f}"


def variance_text(model: ArticulatoryModel) -> str:
    """Table 1 in Markdown, percent."""
    lines = ["| parameter | % | sum | paper, % | sum |", "|---|---|---|---|---|"]
    lines += [f"| {' | '.join(row)} |" for row in variance_table(model)]
    return "\n".join(lines) + "\n"


@dataclass(frozen=True)
class Box:
    """One box of figure 2: how a viseme's points miss, mm.

    Parameters
    ----------
    worst : str
        The point that is missed most.
    drawn : dict
        Quartiles, whiskers and outliers, as matplotlib's `boxplot_stats` names them.
    """

    viseme: str
    rms: float
    worst: str
    drawn: dict[str, Any]


def boxes(visemes: Sequence[str], names: Sequence[str], errors: FloatArray) -> tuple[Box, ...]:
    """Data of figure 2 of errors (V, N), mm; NaN, where a point is missing, is left out."""
    return tuple(_box(v, names, row) for v, row in zip(visemes, errors, strict=True))


def _box(viseme: str, names: Sequence[str], errors: FloatArray) -> Box:
    values = np.sort(errors[np.isfinite(errors)])
    (drawn,) = boxplot_stats(values, labels=[plain(viseme)])
    return Box(viseme, float(rms(values)), names[int(np.nanargmax(errors))], drawn)


def results(built: Build, left_out: FloatArray | None = None) -> dict[str, Any]:
    """Entries of results.json about the model: fractions and mm.

    Parameters
    ----------
    left_out : (V,) float64, mm, optional
        Of `leave_out_in_turn`; NaN where a viseme could not be left out.

    Returns
    -------
    dict
        ``variance`` (a key for each parameter, and ``total``), ``model_error_mm_median`` and
        ``model_error_mm_worst`` (over the visemes), ``model_error_below_half_mm`` (share of the
        visemes), and ``left_out_error_mm_median`` where it was computed.
    """
    shares = {
        n: float(v) for n, v in zip(built.model.parameters, built.model.variance, strict=True)
    }
    errors = built.viseme_errors
    out: dict[str, Any] = {
        "variance": {**shares, "total": built.model.held},
        "model_error_mm_median": float(np.median(errors)),
        "model_error_mm_worst": float(errors.max()),
        "model_error_below_half_mm": float((errors <= 0.5).mean()),
    }
    if left_out is not None and np.isfinite(left_out).any():
        out["left_out_error_mm_median"] = float(np.nanmedian(left_out))
    return out
