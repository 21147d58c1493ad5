"""Coverage of landmarks: those that a system leaves out, so that none go unnoticed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray
from abs_engine.evaluate.estimate import Estimate
from abs_engine.evaluate.metrics.bootstrap import Mean
from abs_engine.io.assets import LIPS_OF_68

LEAST_GIVEN = 0.5
"""Share of its landmarks below which a frame fails."""

_MOST_NAMED = 8


@dataclass(frozen=True, eq=False)
class Given:
    """Landmarks that a system gives.

    Parameters
    ----------
    expected : (68,) bool
        Those that it gives in some frame.
    missing : (T, 68) bool
        Those of them that a tracked frame lacks, in mm or in px where it gives both.
    found : (T,) bool
        Tracked frames.
    """

    expected: BoolArray
    missing: BoolArray
    found: BoolArray

    @property
    def failed(self) -> BoolArray:
        """Frames (T,) that lack one of the lip landmarks, or more than half of all."""
        most = self.missing.sum(axis=1) > (1 - LEAST_GIVEN) * self.expected.sum()
        return np.asarray(self.missing[:, LIPS_OF_68].any(axis=1) | most)

    def means(self) -> dict[str, Mean]:
        """Share of the landmarks, and of those of the lips, that the tracked frames have."""
        means: dict[str, Mean] = {}
        for name, which in (("landmarks", np.arange(68)), ("lips", LIPS_OF_68)):
            count = int(self.expected[which].sum())
            if count:
                share = 1 - self.missing[:, which].sum(axis=1) / count
                means[f"{name}_given"] = Mean.of(np.where(self.found, share, np.nan))
        return means

    def notes(self) -> tuple[str, ...]:
        """Names the points that are missing somewhere."""
        points = np.flatnonzero(self.missing.any(axis=0))
        if not points.size:
            return ()
        named = ", ".join(str(point) for point in points[:_MOST_NAMED])
        more = f" and {len(points) - _MOST_NAMED} more" if points[_MOST_NAMED:].size else ""
        frames = int(self.missing.any(axis=1).sum())
        failed = int(self.failed.sum())
        return (
            f"{frames} of {int(self.found.sum())} tracked frames lack points that are given in "
            f"others ({named}{more}): they are scored by the points they have, and {failed} of "
            "them count as failed",
        )


def given_landmarks(
    estimate: Estimate, own_pixels: bool, landmark_68: NDArray[Any] | None
) -> Given | None:
    """The part of the 68 landmarks that an estimate gives; None where it gives none.

    Parameters
    ----------
    estimate : Estimate
        Complete, see `derived_rows.complete`.
    own_pixels : bool
        Whether its pixels are its own word, and not its points by the true camera.
    landmark_68 : (68,) int, optional
        The landmarks on the truth's mesh.
    """
    known: list[BoolArray] = []
    track = estimate.tracks.get("landmarks")
    if track is not None and landmark_68 is not None:
        place = {int(vertex): k for k, vertex in enumerate(landmark_68)}
        here = [n for n, vertex in enumerate(track.vertex) if int(vertex) in place]
        solid = np.zeros((len(estimate), 68), bool)
        there = [place[int(track.vertex[n])] for n in here]
        solid[:, there] = np.isfinite(track.points[:, here]).all(axis=2)
        known.append(solid)
    if own_pixels and estimate.pixels is not None:
        known.append(np.asarray(np.isfinite(estimate.pixels).all(axis=2)))
    expected, missing = np.zeros(68, bool), np.zeros((len(estimate), 68), bool)
    for flags in known:
        ever = flags[estimate.found].any(axis=0)
        expected |= ever
        missing |= ever & ~flags & estimate.found[:, None]
    return Given(expected, missing, estimate.found) if expected.any() else None
