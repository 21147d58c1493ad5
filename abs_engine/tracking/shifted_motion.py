"""A head's motion with a constant correction of its poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.tracking.frame_state import Follower, HeadFrame, Memory, Motion
from abs_engine.tracking.mouth_search import shifted


@dataclass(frozen=True, eq=False)
class ShiftedMotion:
    """A motion whose poses are all off by the same.

    Parameters
    ----------
    motion : Motion
    shift : (6,) float64
        The correction, radians and mm.
    pivot : (3,) float64, mm, head frame
        What it turns about.
    """

    motion: Motion
    shift: FloatArray
    pivot: FloatArray

    @property
    def alone(self) -> bool:
        """Whether it may be followed in a thread of its own, ahead of the fits."""
        return bool(getattr(self.motion, "alone", False))

    def follower(self) -> ShiftedFollower:
        """Follower of the head from the first frame on."""
        return ShiftedFollower(self, self.motion.follower())


class ShiftedFollower:
    """Corrects what another follower finds."""

    def __init__(self, motion: ShiftedMotion, own: Follower) -> None:
        self._motion, self._own = motion, own

    def step(self, image: NDArray[np.uint8], memory: Memory) -> HeadFrame:
        """The next frame with the head's corrected pose."""
        found = self._own.step(image, memory)
        if found.pose is None:
            return found
        return found._replace(pose=shifted(found.pose, self._motion.shift, self._motion.pivot))

    def finish(self) -> None:
        """Say that there are no more frames."""
        self._own.finish()
