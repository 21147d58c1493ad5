"""The landmark network's mouth: its distance from drawn lips, evidence of a frame, and a check."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from abs_engine.compare.prior import InformationPrior
from abs_engine.compare.residual_rows import Rows
from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import at_base
from abs_engine.core.scene import Candidates
from abs_engine.fit.problem import Problem
from abs_engine.tracking.detection.landmarks import LIPS, OUTER_RING, Landmarks
from abs_engine.tracking.frame.frame_state import HeadFrame
from abs_engine.tracking.landmark.landmark_shape import LandmarkShape
from abs_engine.tracking.person.identity_fit import POSE_DEVIATION


@dataclass(frozen=True, eq=False)
class LipLandmarks:
    """The 40 landmarks of the lips on a person's head.

    Parameters
    ----------
    mean : (40, 3) float64, mm, head frame
    modes : (P, 40, 3) float64, mm per standard deviation
    deviation : (40, 2) float64, mm
        Of the network, along the line of the eyes and down the face.
    bias : (40, 2) float64, mm
        By how much it sees this person's lips off.
    """

    mean: FloatArray
    modes: FloatArray
    deviation: FloatArray
    bias: FloatArray
    camera: Camera

    @classmethod
    def of(
        cls, shape: LandmarkShape, modes: int, camera: Camera, person: FloatArray | None = None
    ) -> LipLandmarks:
        """Of a person's landmarks, whose posture's first `modes` are the mouth's.

        With `person` (Q, 468, 3), mm, these modes of the person's come after them.
        """
        more = np.zeros((0, len(LIPS), 3)) if person is None else person[:, LIPS]
        moves = np.concatenate([shape.posture[:modes, LIPS], more])
        return cls(shape.mean[LIPS], moves, shape.deviation[LIPS, :2], shape.bias[LIPS], camera)

    def in_picture(self, pose: Pose, posture: FloatArray) -> float:
        """Share of the lips' outer edge that lies in the picture in a pose and posture (P,)."""
        edge, modes = (part[..., : len(OUTER_RING), :] for part in (self.mean, self.modes))
        there = self.camera.project(pose.apply(edge + np.tensordot(posture, modes, 1)))
        inside = (there > -0.5) & (there < np.array(self.camera.size) - 0.5)
        return float(inside.all(axis=1).mean())

    def apart(self, seen: Landmarks, pose: Pose, posture: FloatArray) -> tuple[float, float]:
        """RMS distance of lips in a pose and posture (P,) from those seen.

        In mm across the line of sight, and in standard deviations of the network.
        """
        mm = self.off(seen, Candidates.one(posture, pose))[0]
        off_mm = float(np.sqrt((mm**2).sum(axis=1).mean()))
        return off_mm, float(np.sqrt(((mm / self.deviation) ** 2).mean()))

    def off(self, seen: Landmarks, candidates: Candidates) -> FloatArray:
        """By how much the lips of candidates lie off those seen, (B, 40, 2), mm."""
        points = self.mean + np.tensordot(candidates.weights, self.modes, 1)
        turned = points @ candidates.rotations.transpose(0, 2, 1)
        there = turned + candidates.translations[:, None]
        depth = there[..., 2:]
        off = there[..., :2] / depth - self.camera.undistort(seen.pixels[LIPS])
        return np.asarray(off @ np.stack(seen.axes).T * depth + self.bias)


@dataclass(frozen=True, eq=False)
class LipOutline:
    """Landmarks of a frame's lips as evidence over pose and weights.

    Parameters
    ----------
    strength : float
        Nats for each squared standard deviation that the lips lie off (mean).
    """

    lips: LipLandmarks
    seen: Landmarks
    strength: float

    @property
    def drawn(self) -> bool:
        """Whether it draws anything: Newton's steps may ask it for differences."""
        return False

    def negative_log(self, candidates: Candidates) -> FloatArray:
        """-log likelihood of each candidate, (B,), nats."""
        return self.rows(candidates).value

    def rows(self, candidates: Candidates) -> Rows:
        """Residuals that are squared and summed: how far each point is seen off."""
        off = self.lips.off(self.seen, candidates).reshape(len(candidates), -1)
        size = self.strength / self.lips.deviation.size
        rows = np.sqrt(size) * off / self.lips.deviation.ravel()
        return Rows(rows, np.ones(rows.shape, bool), (rows**2).sum(axis=1))


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
