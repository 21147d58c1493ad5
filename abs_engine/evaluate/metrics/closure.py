"""Closed lips: which frames and which closures are found, and how far off their onset is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import linear_sum_assignment

from abs_engine.core.arrays import BoolArray, IntArray, stretches
from abs_engine.core.errors import ParameterError


def closed_intervals(closed: ArrayLike) -> IntArray:
    """Runs of closed frames, (E, 2): the first frame of each, and the first one after it."""
    return np.array(stretches(np.asarray(closed, bool)), np.int64).reshape(-1, 2)


def match_events(estimated: IntArray, truth: IntArray) -> IntArray:
    """Pairs (P, 2) of closures, index of the estimated and of the true one, that overlap in time.

    One to one; of all assignments the one with the largest total overlap.
    """
    first = np.maximum(estimated[:, None, 0], truth[None, :, 0])
    last = np.minimum(estimated[:, None, 1], truth[None, :, 1])
    overlap = np.maximum(last - first, 0)
    rows, columns = linear_sum_assignment(overlap, maximize=True)
    pairs = np.stack([rows, columns], axis=1)[overlap[rows, columns] > 0]
    return np.asarray(pairs, np.int64)


@dataclass(frozen=True, eq=False)
class ClosureEvents:
    """Closures found and true, as runs of frames, and which of them belong together.

    Parameters
    ----------
    found, true : (E, 2) int64
        See `closed_intervals`.
    pairs : (P, 2) int64
        See `match_events`.
    sure : (P,) bool
        Whether it is known of both closures of a pair that the frame before is open.
    """

    found: IntArray
    true: IntArray
    pairs: IntArray
    sure: BoolArray

    @property
    def onsets(self) -> IntArray:
        """First frames (P', 2) of the pairs, found and true.

        Not of closures that begin a clip, or that are found after a lost frame, or where the truth
        is not seen before.
        """
        both = np.stack([self.found[self.pairs[:, 0], 0], self.true[self.pairs[:, 1], 0]], axis=1)
        return both[(both > 0).all(axis=1) & self.sure]


def closure_events(
    estimated: ArrayLike,
    truth: ArrayLike,
    lost: ArrayLike | None = None,
    unseen: ArrayLike | None = None,
) -> ClosureEvents:
    """Closures (runs of closed frames) against the true ones.

    One is found if it overlaps with a true one, each being used once: the event-based scores of
    Mesaros, Heittola & Virtanen, Metrics for polyphonic sound event detection, Applied Sciences 6
    (2016), with overlap instead of a collar around onsets.

    Parameters
    ----------
    estimated, truth : (T,) bool
    lost : (T,) bool, optional
        Frames of which the estimate says nothing. Those within a true closure do not divide what
        is found on both sides of them.
    unseen : (T,) bool, optional
        Frames that do not count: a true closure that goes on while the head is out of the picture
        has no onset where the head comes back.

    Raises
    ------
    ParameterError
        If the lengths differ.
    """
    closed, true_closed = _same_frames(estimated, truth)
    never = np.zeros_like(closed)
    _, unknown = _same_frames(closed, never if lost is None else lost)
    _, away = _same_frames(closed, never if unseen is None else unseen)
    found = closed_intervals(_joined(closed, true_closed, unknown))
    true = closed_intervals(true_closed)
    pairs = match_events(found, true)
    before = [np.maximum(k[:, 0] - 1, 0) for k in (found[pairs[:, 0]], true[pairs[:, 1]])]
    return ClosureEvents(found, true, pairs, ~unknown[before[0]] & ~away[before[1]])


def _joined(closed: BoolArray, truth: BoolArray, lost: BoolArray) -> BoolArray:
    """Closed frames, with lost ones between two of them that are closed in truth, (T,)."""
    out = closed.copy()
    for first, end in stretches(lost & ~closed):
        between = first > 0 and end < len(closed) and closed[first - 1] and closed[end]
        if between and truth[first:end].all():
            out[first:end] = True
    return out


def _same_frames(estimated: ArrayLike, truth: ArrayLike) -> tuple[BoolArray, BoolArray]:
    found, true = np.asarray(estimated, bool), np.asarray(truth, bool)
    if found.shape != true.shape:
        raise ParameterError(
            f"{found.size} frames cannot be compared with {true.size}",
            "compare the same frames of one clip",
        )
    return found, true
