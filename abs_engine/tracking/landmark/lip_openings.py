"""Evidence on the mouth's opening by the distances between landmarks of the inner lips.

A single landmark of the inner lips nearly always counts as hidden, as the surface there faces the
other lip; and where a lip is thicker or thinner than its modes make it, both lie off alike. The
distance between the two is what the network sees best: the upper and the lower one are on one line
across the opening, and the lips' red beside them is in view.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.geometry import Pose
from abs_engine.tracking.detection.landmarks import INNER_PAIRS, OUTER_PAIRS, SeenRays
from abs_engine.tracking.landmark.head_equations import Equations
from abs_engine.tracking.landmark.landmark_shape import LandmarkShape, in_view
from abs_engine.tracking.settings.landmarks import LANDMARK_EVIDENCE

_PLACES = INNER_PAIRS.shape[1]


@dataclass(frozen=True, eq=False)
class LipOpenings:
    """Nine distances between the inner lips of a person, down the face, as they are seen.

    Parameters
    ----------
    mean : (36, 3) float64, mm, head frame
        Nine landmarks of the upper lip's inner edge, nine of the lower lip's, then those of the
        outer edges beside them in the same order.
    modes : (M, 36, 3) float64, mm per standard deviation
    normals : (18, 3) float64
        Of the outer edges.
    pivot : (3,) float64, mm
    seen : (9,) float64
        Distances seen, at depth 1; negative where the lips overlap.
    down : (2,) float64
        Unit vector down the face.
    trust : (9,) float64
        Weight of each, 0 to 1.
    bias : (9,) float64, mm
        By how much the network sees this person's distances off.
    pixel : float
        Width of a pixel at depth 1.
    """

    mean: FloatArray
    modes: FloatArray
    normals: FloatArray
    pivot: FloatArray
    seen: FloatArray
    down: FloatArray
    trust: FloatArray
    bias: FloatArray
    pixel: float

    @classmethod
    def of(cls, shape: LandmarkShape, seen: SeenRays) -> LipOpenings:
        """The distances of a frame's landmarks on a person's head."""
        (upper, lower), down = INNER_PAIRS, seen.axes[1]
        points = np.r_[INNER_PAIRS.ravel(), OUTER_PAIRS.ravel()]
        return cls(
            shape.mean[points],
            np.ascontiguousarray(shape.posture[:, points]),
            shape.normals[OUTER_PAIRS.ravel()],
            shape.pivot,
            (seen.rays[lower] - seen.rays[upper]) @ down,
            down,
            np.minimum(seen.trust[lower], seen.trust[upper]),
            shape.bias[lower, 1] - shape.bias[upper, 1],
            seen.pixel,
        )

    def equations(self, pose: Pose, posture: FloatArray) -> Equations:
        """Equations of the posture (M,) about a pose and a posture.

        Each counts less where the lips beside it are hidden, or where it is far off (Cauchy). What
        they say of the pose is left out: a turn by 3 degrees changes them by 0.6 mm at most.
        """
        moved = posture @ self.modes.reshape(len(posture), self.mean.size)
        there = pose.apply(self.mean + moved.reshape(self.mean.shape))
        inner, outer = np.split(there, [2 * _PLACES])
        distance = float(pose.apply(self.pivot)[2])
        rays = inner[:, :2] / inner[:, 2:]
        opened = (rays[_PLACES:] - rays[:_PLACES]) @ self.down
        off = (opened - self.seen) * distance + self.bias
        variance = self._variance(distance)
        shown = in_view(self.normals, pose, outer).reshape(2, _PLACES).min(axis=0)
        stray = 1 + off**2 / (LANDMARK_EVIDENCE.stray**2 * variance)
        weight = self.trust * shown / (stray * variance * LANDMARK_EVIDENCE.openings_together)
        moves = self._motion(pose, inner, distance)
        return Equations((moves * weight) @ moves.T, moves @ (weight * off))

    def _variance(self, distance: float) -> FloatArray:
        """Of each distance, mm2, on a head that is this far away, mm."""
        fixed = LANDMARK_EVIDENCE.opening_least**2
        fixed += (LANDMARK_EVIDENCE.opening_pixels * self.pixel * distance) ** 2
        opening = np.maximum(self.seen * distance, 0.0)
        return np.asarray(fixed + (LANDMARK_EVIDENCE.opening_share * opening) ** 2)

    def _motion(self, pose: Pose, inner: FloatArray, distance: float) -> FloatArray:
        """Motion apart of the inner lips (18, 3), camera frame, with each mode, (M, 9), mm."""
        moved = self.modes[:, : 2 * _PLACES] @ pose.rotation.T
        across = moved[..., :2] - moved[..., 2:] * inner[:, :2] / inner[:, 2:]
        lips = across @ self.down * (distance / inner[:, 2])
        return np.asarray(lips[:, _PLACES:] - lips[:, :_PLACES])
