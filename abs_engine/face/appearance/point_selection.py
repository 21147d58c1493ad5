"""Selection of points with local appearance, and their scale (Odisio & Bailly, 3.2 and 6)."""

from __future__ import annotations

import numpy as np

from abs_engine.core.arrays import BoolArray, FloatArray, IntArray
from abs_engine.core.errors import ParameterError
from abs_engine.face.appearance.local import LocalModel
from abs_engine.face.settings.appearance import APPEARANCE

N_POINTS = 63
"""The paper's N."""


def choose_points(
    model: LocalModel,
    count: int = N_POINTS,
    places: FloatArray | None = None,
    spacing: float = 0.0,
    whiten: bool = False,
) -> IntArray:
    """Choose points by the variance that each parameter reconstructs of their descriptors.

    For each parameter the points are ranked by the variance that its column of M_D reconstructs;
    the parameters take turns, each with its best point that is not yet chosen, so duplicates go.

    Parameters
    ----------
    model : LocalModel
        Of all points, with modes.
    count : int
        How many points to choose; fewer come back if there are no more.
    places : (N, 3) float64, mm, optional
        Where the points are, for `spacing`.
    spacing : float, mm
        Points nearer than that to a chosen one are duplicates of it.
    whiten : bool
        Weigh each component by what the model leaves unexplained of it; the paper does not.

    Returns
    -------
    (count,) int64
        Indices of the model's points, in the order in which they were chosen.

    Raises
    ------
    ParameterError
        If the model is constant, or no point is seen often and squarely enough.
    """
    if len(model.modes) == 0:
        raise ParameterError("constant appearance ranks no points", "choose before `constant`")
    usable = usable_points(model)
    gains = reconstructed(model, whiten)
    gains[:, ~usable] = -1.0
    ranks = [list(np.argsort(-row, kind="stable")[: int(usable.sum())]) for row in gains]
    return _by_turns(ranks, usable, count, places, spacing)


def usable_points(model: LocalModel) -> BoolArray:
    """Mask (N,) of points seen often and squarely enough; `ParameterError` if none is."""
    usable = np.asarray((model.seen >= APPEARANCE.often) & (model.facing >= APPEARANCE.squarely))
    if not usable.any():
        raise ParameterError(
            f"no point is seen squarely in {APPEARANCE.often:.0%} of the frames",
            "give points in front of the face",
        )
    return usable


def _by_turns(
    ranks: list[list[np.intp]],
    free: BoolArray,
    count: int,
    places: FloatArray | None,
    spacing: float,
) -> IntArray:
    """Each rank's best that is still free, in turns; what is within `spacing` of one is not."""
    chosen: list[int] = []
    while len(chosen) < count and any(ranks):
        for rank in ranks:
            while rank and not free[rank[0]]:
                rank.pop(0)
            if rank and len(chosen) < count:
                best = int(rank.pop(0))
                chosen.append(best)
                free[best] = False
                if places is not None and spacing > 0:
                    free &= np.linalg.norm(places - places[best], axis=1) >= spacing
    return np.array(chosen, np.int64)


def reconstructed(model: LocalModel, whiten: bool = False) -> FloatArray:
    """Variance (P, N) of each point's descriptor that each parameter's column of M_D makes."""
    modes = model.modes / np.maximum(model.spread, 1e-6) if whiten else model.modes
    return np.asarray(((modes * model.reach[:, None, None]) ** 2).sum(axis=2))
