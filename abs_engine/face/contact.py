"""Contact of the lips, and how thick each is, as linear functions of a posture."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.scene import Scene
from abs_engine.face.settings.shape import SHAPE

Rings = Mapping[str, NDArray[np.integer]]


MIDDLE, SIDES = 4, (2, 6)
"""Of the nine gaps from corner to corner: the mouth's middle, and half-way to its corners."""


def lip_gaps(scene: Scene, rings: Rings) -> tuple[FloatArray, FloatArray]:
    """Gaps (G,) between the lips, mm, and their change (G, P) per unit of a posture's parameter.

    Heights of upper above lower inner lip at the mean posture, from corner to corner; for the lips'
    contours, `rings`, see `face.base.Face`.
    """
    upper, lower = rings["upper"], rings["lower"]
    at = scene.mean[lower, 0]
    order = np.argsort(scene.mean[upper, 0])
    x = scene.mean[upper, 0][order]
    picked = np.linspace(0.1, 0.9, 9) * np.ptp(x) + x[0]
    up = upper[order][np.searchsorted(x, picked).clip(0, len(x) - 1)]
    down = lower[np.abs(at[:, None] - picked).argmin(axis=0)]
    gap = scene.mean[up, 1] - scene.mean[down, 1]
    slope = scene.modes[:, up, 1] - scene.modes[:, down, 1]
    return gap.astype(np.float64), slope.T.astype(np.float64)


def pinching(gap: FloatArray, slope: FloatArray) -> tuple[FloatArray, FloatArray]:
    """By how much a mouth's middle opens farther than its sides do, (1,), mm, of `lip_gaps`.

    Negative where the middle is pinched, see `SHAPE.pinched`; and its change (1, P).
    """
    share = np.zeros(len(gap))
    share[[MIDDLE, *SIDES]] = 1.0, *(-0.5 * SHAPE.pinched for _ in SIDES)
    return np.array([share @ gap + SHAPE.pinch_slack]), (share @ slope)[None]


def lip_heights(scene: Scene, rings: Rings) -> tuple[FloatArray, FloatArray]:
    """Heights (H,) of the lips, mm, and their change (H, P) per unit of a posture's parameter.

    From the inner to the outer contour at the mean posture, upper lip, then lower.
    """
    outer = rings["outer"]
    x, y = scene.mean[outer, 0], scene.mean[outer, 1]
    middle = scene.mean[rings["corners"], 1].mean()
    reach = SHAPE.lip_reach * float(np.ptp(x)) / 2
    stations = np.linspace(-reach, reach, 7) + float(x.max() + x.min()) / 2
    height, change = [], []
    for ring, sign in (("upper", 1.0), ("lower", -1.0)):
        edge = outer[sign * (y - middle) > 0]
        inner = rings[ring]
        out = edge[np.abs(scene.mean[edge, 0][:, None] - stations).argmin(axis=0)]
        into = inner[np.abs(scene.mean[inner, 0][:, None] - stations).argmin(axis=0)]
        height.append(sign * (scene.mean[out, 1] - scene.mean[into, 1]))
        change.append(sign * (scene.modes[:, out, 1] - scene.modes[:, into, 1]).T)
    return np.concatenate(height).astype(np.float64), np.vstack(change).astype(np.float64)
