"""The distance of drawn lips from the lips that the landmark network sees."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from abs_engine.compare.residual_rows import Rows
from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Candidates
from abs_engine.tracking.landmark_shape import LandmarkShape
from abs_engine.tracking.landmarks import LIPS, OUTER_RING, Landmarks


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
    camera : Camera
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

        Returns
        -------
        mm, deviations : float
            Across the line of sight; and in standard deviations of the network.
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
    lips : LipLandmarks
    seen : Landmarks
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
