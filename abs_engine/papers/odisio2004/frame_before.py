"""A frame of a talking face as it is fitted: from the frame before, and again if that is bad."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import at_base, parted
from abs_engine.fit.problem import Problem
from abs_engine.fit.search import Again
from abs_engine.tracking.frame.clip_setting import UNEXPLAINED, Work
from abs_engine.tracking.frame.frame_state import Follower, HeadFrame, Memory, Motion

SPEEDS = (0.0, 0.5, 1.0)
"""Shares of the last movement that are tried for the next one."""
MakeProblem = Callable[[Image, Pose, FloatArray], Problem]
"""The problem of a picture about a pose and a posture (P,)."""


@dataclass(frozen=True, eq=False)
class TalkBinder:
    """Starts each frame from the one before.

    As Odisio and Bailly (section 4) have it the best parameters of a frame are where the search of
    the next one starts. Beyond it: the start is predicted from the last movement, and a search that
    ends with an unusually large value starts again from the best of known postures.

    Parameters
    ----------
    neutral : (P,) float64
        The posture to begin with where there is no frame before.
    postures : (K, P) float64, optional
        From which a search may start again.
    unusual : float
        Times the median value of the last frames.
    least : float
        How much of the picture a fit explains at least; else it is of no face.
    """

    problem: MakeProblem
    neutral: FloatArray
    predict: bool
    postures: FloatArray | None
    unusual: float
    least: float

    def work(self, frame: HeadFrame, pose: Pose, memory: Memory) -> Work:
        """Objective of a frame whose head is about a pose, and the start of its search."""
        posture = self.neutral if memory.vector is None else parted(memory.vector)[1]
        made = self.problem(frame.image, pose, posture)
        last, starts = at_base(posture), at_base(posture)[None]
        if self.predict and memory.move is not None and memory.move.any():
            ahead = made.chosen(last + np.outer(SPEEDS, memory.move))
            starts = np.array([made.whole(made.spec.clip(row)) for row in ahead])
        again = None
        if self.predict and self.postures is not None:
            usual = float(np.median(memory.values)) if memory.values else np.inf
            limit = self.unusual * usual * made.unit
            again = Again(self.postures, lambda value: value > limit)
        return Work(
            made, starts, lambda value: max(0.0, 1.0 - value.value / made.unit), again=again,
            doubt=lambda _x, score: "" if score >= self.least else UNEXPLAINED,
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class FrameBefore:
    """A head that is where it was in the frame before.

    Parameters
    ----------
    finding : Motion, optional
        What finds the head in the first frame, and where the one before was lost.
    """

    finding: Motion | None = None

    def follower(self) -> FrameBeforeFollower:
        """Follower of the head from the first frame on."""
        return FrameBeforeFollower(None if self.finding is None else self.finding.follower())


class FrameBeforeFollower(Follower):
    """Follows by memory alone, and looks for the head where there is none."""

    def __init__(self, finding: Follower | None) -> None:
        self._finding = finding

    def step(self, image: Image, memory: Memory) -> HeadFrame:
        """The next frame with the pose of the one before."""
        # in every frame, as it counts them and follows the face
        found = None if self._finding is None else self._finding.step(image, memory)
        if found is not None and memory.vector is None:
            return found
        return HeadFrame(image, memory.pose)
