"""The landmark network's mouth: evidence of a frame, and a check of what was found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from abs_engine.compare.prior import InformationPrior
from abs_engine.core.arrays import FloatArray
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import at_base
from abs_engine.fit.problem import Problem
from abs_engine.tracking.frame_state import HeadFrame
from abs_engine.tracking.identity_fit import POSE_DEVIATION
from abs_engine.tracking.lip_landmarks import LipLandmarks

BOTH, RENDERING, LANDMARKS = EVIDENCE = ("both", "rendering", "landmarks")


@dataclass(frozen=True, eq=False)
class Landmarked:
    """Evidence of landmarks in a frame that is fitted.

    Parameters
    ----------
    alone : Problem
        The frame by its landmarks and priors, without what is drawn.
    told : (6 + P,) float64
        Where they put the mouth.
    apart : callable or None
        How far lips in a pose and posture lie off them (RMS), in mm and in standard deviations.
    only : bool
        Whether nothing else counts.
    decide : bool
        Whether a fit that lies off them is not accepted.
    why : str
        Why nothing else counts, as the frame's status says; empty where it was asked for.
    """

    alone: Problem
    told: FloatArray
    apart: Callable[[Pose, FloatArray], tuple[float, float]] | None
    only: bool = False
    decide: bool = True
    why: str = ""


@dataclass(frozen=True, eq=False)
class MouthLandmarks:
    """Evidence of the mouth's landmarks in each frame; without a network's face in it, not at all.

    Parameters
    ----------
    modes : int
        Of the posture that they know: its first ones are the mouth's.
    lips : LipLandmarks, optional
        Where the network sees the lips of this head; without it what is found is not checked.
    evidence : str
        What counts: "both", or "rendering" or "landmarks" alone, to see what each adds.
    """

    modes: int
    lips: LipLandmarks | None = None
    evidence: str = BOTH

    def told(self, frame: HeadFrame) -> FloatArray | None:
        """Mouth according to the landmarks, (6 + P,)."""
        return None if frame.face is None else at_base(frame.face.fit.posture[: self.modes])

    def beside(self, frame: HeadFrame, factor: float) -> tuple[InformationPrior, ...]:
        """Landmarks' evidence beside what is drawn, its noise in the posture times `factor`."""
        if frame.face is None or self.evidence == RENDERING:
            return ()
        return (_less_sure(frame.face.fit.evidence(self.modes), factor),)

    def alone(self, frame: HeadFrame) -> bool:
        """Whether colours say nothing in a frame, and its landmarks count."""
        return frame.grey and frame.face is not None and self.evidence != RENDERING

    def marked(self, frame: HeadFrame, undrawn: Problem, why: str = "") -> Landmarked | None:
        """Evidence in the form that the loop needs; `undrawn` is the frame by its priors alone.

        `why` is why nothing but landmarks counts in it; by default the rest does, too, if it was
        asked.
        """
        face, told = frame.face, self.told(frame)
        if face is None or told is None:
            return None
        priors = (*undrawn.priors, face.fit.evidence(self.modes))
        apart = None if self.lips is None else partial(self.lips.apart, face.landmarks)
        only, decide = bool(why) or self.evidence == LANDMARKS, self.evidence == BOTH
        return Landmarked(replace(undrawn, priors=priors), told, apart, only, decide, why)


def _less_sure(told: InformationPrior, factor: float) -> InformationPrior:
    """Evidence of landmarks, their noise in the posture this many times as large."""
    scale = at_base(np.full(len(told.mean), 1 / factor))[: len(told.mean)]
    scale[: len(POSE_DEVIATION)] = 1.0
    return replace(told, information=told.information * np.outer(scale, scale))
