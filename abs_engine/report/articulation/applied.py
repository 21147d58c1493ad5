"""An articulatory model applied to recorded points: parameters of every frame."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from abs_engine.core.arrays import BoolArray, FloatArray, IntArray
from abs_engine.core.errors import ParameterError, TooFewPointsError
from abs_engine.face.shape.articulatory_model import ArticulatoryModel

_LEAST_SIZE = 0.2
"""Of points, in sizes of the model's own, or the reverse: few points differ by less, units by more.
"""


@dataclass(frozen=True, eq=False)
class Applied:
    """Parameters of T frames.

    Parameters
    ----------
    alpha : (T, P) float64, standard deviations
        NaN where too few points are seen.
    error : (T,) float64, mm
        Root mean square distance of the points seen from where the model puts them.
    seen : (T,) int64
        How many of the model's points are seen.
    lacking : tuple of str
        The model's points that are in no frame.
    farthest : tuple of str
        The point of each frame that is farthest from where the model puts it; empty where the
        frame has no parameters.
    off : (T,) float64, mm
        Distance of that point from there; NaN where the frame has no parameters.
    first : int
        Number of the first frame.
    """

    names: tuple[str, ...]
    alpha: FloatArray
    error: FloatArray
    seen: IntArray
    lacking: tuple[str, ...]
    farthest: tuple[str, ...]
    off: FloatArray
    first: int = 0

    @property
    def found(self) -> BoolArray:
        """Mask (T,) of the frames that have parameters."""
        return np.asarray(np.isfinite(self.error), np.bool_)

    def as_csv(self) -> str:
        """A line for each frame; the cells of what was not found are empty."""
        text = io.StringIO()
        table = csv.writer(text, lineterminator="\n")
        table.writerow(("frame", *self.names, "rms_mm", "points"))
        rows = zip(self.alpha, self.error, self.seen, self.found, strict=True)
        for frame, (alpha, error, seen, found) in enumerate(rows, self.first):
            values = [f"{v:.4f}" if found else "" for v in (*alpha, error)]
            table.writerow((frame, *values, seen))
        return text.getvalue()


def apply_model(
    model: ArticulatoryModel, names: Sequence[str], points: FloatArray, first: int = 0
) -> Applied:
    """The direct inversion of each frame; points go together by their names.

    Parameters
    ----------
    names : sequence of str, N
        Of the recorded points; those that the model lacks are not used.
    points : (T, N, 3) float64, mm, the frame of the model's corpus
        NaN where one is missing.

    Raises
    ------
    ParameterError
        If none of the points is the model's, or they are in another unit.
    TooFewPointsError
        If no frame has enough of them.
    """
    at = {name: k for k, name in enumerate(names)}
    own = [k for k, name in enumerate(model.names) if name in at]
    if not own:
        raise ParameterError(
            "none of the points is one of the model's",
            f"name them as in its corpus, such as {', '.join(model.names[:3])}",
        )
    placed = np.full((len(points), len(model.names), 3), np.nan)
    placed[:, own] = points[:, [at[model.names[k]] for k in own]]
    _check_unit(model, placed)
    alpha = np.array([_inverted(model, frame) for frame in placed])
    away = np.linalg.norm(placed - model.points(alpha), axis=2)
    there = np.isfinite(placed).all(axis=2)
    found = np.isfinite(alpha).all(axis=1)
    if not found.any():
        raise TooFewPointsError(
            f"no frame has enough points for {len(model.parameters)} parameters",
            "record more of the model's points, and those of the upper teeth with them",
        )
    count = np.maximum(there.sum(axis=1), 1)
    error = np.sqrt((np.where(there, away, 0.0) ** 2).sum(axis=1) / count)
    seen = there.any(axis=0)
    known = np.where(there, away, -1.0)
    return Applied(
        model.parameters, alpha, np.where(found, error, np.nan),
        np.asarray(there.sum(axis=1), np.int64),
        tuple(name for name, ever in zip(model.names, seen, strict=True) if not ever),
        tuple(
            model.names[int(k)] if ok else ""
            for k, ok in zip(known.argmax(axis=1), found, strict=True)
        ),
        np.where(found, known.max(axis=1), np.nan), first,
    )  # fmt: skip


def _check_unit(model: ArticulatoryModel, placed: FloatArray) -> None:
    """Refuse frames (T, N, 3) of a model's points that are not of the size of its own."""
    there = np.asarray(np.isfinite(placed).all(axis=2))
    several = there.sum(axis=1) > 1
    if not several.any():
        return
    usual, size = (
        float(np.median(_extents(np.where(there[..., None], p, np.nan)[several])))
        for p in (model.mean, placed)
    )
    if not _LEAST_SIZE * usual <= size <= usual / _LEAST_SIZE:
        raise ParameterError(
            f"the points measure {size:.2g} mm from end to end, the model's {usual:.0f}",
            "are they in mm? say with --unit what they are in",
        )


def _extents(points: FloatArray) -> FloatArray:
    """Diagonals (T,) of the boxes around points (T, N, 3), NaN where one is missing."""
    span = np.nanmax(points, axis=1) - np.nanmin(points, axis=1)
    return np.asarray(np.linalg.norm(span, axis=1))


def _inverted(model: ArticulatoryModel, points: FloatArray) -> FloatArray:
    """Parameters (P,) of a frame (N, 3); NaN where its points do not determine them."""
    try:
        return model.invert(points)
    except TooFewPointsError:
        return np.full(len(model.parameters), np.nan)
