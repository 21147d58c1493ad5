"""Points that bear each other's names in some frames or one view, as mixed-up beads do."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from abs_engine.capture.headframe import HeadMotion
from abs_engine.capture.observations import Observations
from abs_engine.capture.settings import CAPTURE
from abs_engine.capture.triangulate import triangulate
from abs_engine.capture.view import View
from abs_engine.core.arrays import BoolArray, FloatArray

_NAMED = 6
"""Frames that a message names at most. Chosen."""

Pairs = dict[tuple[int, int], list[int]]


def exchanged(points: FloatArray, usual: FloatArray, off: BoolArray) -> Pairs:
    """Pairs of points that lie where each other should be, with their frames.

    Parameters
    ----------
    points : (T, K, 3) float64, mm
    usual : (T, K, 3) float64, mm
        Places at which they should be.
    off : (T, K) bool
        Points to look at, as they are off.
    """
    found: Pairs = {}
    for frame in np.flatnonzero(off.sum(axis=1) >= 2):
        at = np.flatnonzero(off[frame])
        own = ((points[frame, at] - usual[frame, at]) ** 2).sum(axis=1)
        across = ((points[frame, at][:, None] - usual[frame, at]) ** 2).sum(axis=2)
        nearer = across + across.T < CAPTURE.nearer**2 * (own[:, None] + own)
        for a, b in combinations(range(len(at)), 2):
            if nearer[a, b]:
                found.setdefault((int(at[a]), int(at[b])), []).append(int(frame))
    return found


def most_often(pairs: Pairs, numbers: Sequence[int]) -> tuple[int, int, str]:
    """The pair found in most frames, and the numbers of these in words."""
    (a, b), frames = max(pairs.items(), key=lambda item: len(item[1]))
    said = ", ".join(str(numbers[frame]) for frame in frames[:_NAMED])
    word = "frame" if len(frames) == 1 else "frames"
    return a, b, f"{word} {said}{', ...' if len(frames) > _NAMED else ''}"


def crossed(observed: Observations, views: Sequence[View], names: Sequence[str]) -> FloatArray:
    """Places (K, K, 3), mm, head frame, where the points lie if one of two views exchanged names.

    Entry (i, j) is where a point lies that the first view calls i and the second j: the mean over
    a few frames in which all of the points were found.

    Raises
    ------
    DegenerateViewsError
        If the views leave depth open.
    """
    at = [observed.names.index(name) for name in names]
    whole = np.flatnonzero(observed.found[:, at].all(axis=1))
    few = whole[:: 1 + len(whole) // CAPTURE.crossed_frames]
    one, other = observed.pixels[:, few][:, :, at]
    seen = np.stack(np.broadcast_arrays(one[:, :, None], other[:, None]))
    head = observed.rotations[few], observed.translations[few], observed.rigid_error[few]
    placed = HeadMotion(*head).to_head(triangulate(views, seen).points)
    return np.asarray(placed.mean(axis=0))
