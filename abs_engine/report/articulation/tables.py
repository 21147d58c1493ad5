"""Table 1 beside the paper's, the data of figure 2, and both as values for results.json."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.face.shape.articulatory_model import ArticulatoryModel
from abs_engine.learn.articulatory import Build, rms

PAPER_VARIANCE = {
    "jaw1": 0.1611, "lips1": 0.5010, "lips2": 0.1019, "lips3": 0.0960, "lips4": 0.0672,
    "jaw2": 0.0160, "lar1": 0.0196,
}  # fmt: skip
"""Table 1, fractions."""
PAPER_TOTAL = 0.9629
"""As printed; the rows add up to 0.9628."""


@dataclass(frozen=True)
class VarianceRow:
    """A line of table 1, fractions of the variance.

    Parameters
    ----------
    share, cumulated : float
        Of this model.
    paper, paper_cumulated : float or None
        Of the paper, where it has the parameter.
    """

    name: str
    share: float
    cumulated: float
    paper: float | None
    paper_cumulated: float | None

    @property
    def percent(self) -> tuple[str, ...]:
        """The four numbers in percent; empty where there is none."""
        told = (self.share, self.cumulated, self.paper, self.paper_cumulated)
        return tuple("" if v is None else f"{100 * v:.2f}" for v in told)


def variance_table(model: ArticulatoryModel) -> tuple[VarianceRow, ...]:
    """Table 1: what each parameter explains, and all up to it, beside the paper's."""
    sums = np.cumsum(list(PAPER_VARIANCE.values()))
    sums[-1] = PAPER_TOTAL
    totals = dict(zip(PAPER_VARIANCE, sums, strict=True))
    return tuple(
        VarianceRow(name, float(share), float(sum_), PAPER_VARIANCE.get(name), totals.get(name))
        for name, share, sum_ in zip(
            model.parameters, model.variance, np.cumsum(model.variance), strict=True
        )
    )


def variance_text(model: ArticulatoryModel) -> str:
    """Table 1 in Markdown, percent."""
    lines = ["| parameter | % | sum | paper, % | sum |", "|---|---|---|---|---|"]
    for row in variance_table(model):
        lines.append(f"| {row.name} | {' | '.join(row.percent)} |")
    return "\n".join(lines) + "\n"


@dataclass(frozen=True)
class Box:
    """One box of figure 2: how a viseme's points miss, mm.

    Parameters
    ----------
    low, first, median, third, high : float
        Quartiles, and the last values within 1.5 times their distance from the box.
    outliers : tuple of float
        Beyond `low` and `high`.
    worst : str
        The point that is missed most.
    """

    viseme: str
    low: float
    first: float
    median: float
    third: float
    high: float
    rms: float
    outliers: tuple[float, ...]
    worst: str


def boxes(visemes: Sequence[str], names: Sequence[str], errors: FloatArray) -> tuple[Box, ...]:
    """Data of figure 2 of errors (V, N), mm; NaN, where a point is missing, is left out."""
    return tuple(_box(v, names, row) for v, row in zip(visemes, errors, strict=True))


def _box(viseme: str, names: Sequence[str], errors: FloatArray) -> Box:
    values = errors[np.isfinite(errors)]
    first, median, third = (float(q) for q in np.percentile(values, (25, 50, 75)))
    reach = 1.5 * (third - first)
    inside = values[(values >= first - reach) & (values <= third + reach)]
    outside = values[(values < first - reach) | (values > third + reach)]
    return Box(
        viseme, float(inside.min()), first, median, third, float(inside.max()),
        float(rms(values)), tuple(float(v) for v in np.sort(outside)),
        names[int(np.nanargmax(errors))],
    )  # fmt: skip


def results(built: Build, left_out: FloatArray | None = None) -> dict[str, Any]:
    """Entries of results.json about the model: fractions and mm.

    Parameters
    ----------
    left_out : (V,) float64, mm, optional
        Of `left_out_errors`; NaN where a viseme could not be left out.

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
