"""Evidence on the mouth's opening by the distances between landmarks of the inner lips.

A single landmark of the inner lips nearly always counts as hidden, as the surface there faces the
other lip; and where a lip is thicker or thinner than its modes make it, both lie off alike. The
distance between the two is what the network sees best: the upper and the lower one are on one line
across the opening, and the lips' red beside them is in view.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.geometry import Pose
from abs_engine.tracking.landmark_rays import SeenRays
from abs_engine.tracking.landmark_shape import LandmarkShape, in_view
from abs_engine.tracking.landmarks import INNER_RING, OUTER_RING
from abs_engine.tracking.settings.landmarks import LANDMARK_EVIDENCE

_UPPER, _LOWER = INNER_RING[:10:-1], INNER_RING[1:10]
_BESIDE = np.concatenate([OUTER_RING[:10:-1], OUTER_RING[1:10]])
_PLACES = len(_UPPER)
_LEAST_DEPTH = 1e-3  # mm, by which a lip moves in depth at all


class OpeningEquations(NamedTuple):
    """Evidence on a posture about where it is now, as part of normal equations.

    Parameters
    ----------
    information : (M, M) float64
    gradient : (M,) float64
        Of -log likelihood.
    slope : (M, M) float64
        How the gradient changes with the posture; not symmetric, as depth is left out of the
        gradient alone.
    """

    information: FloatArray
    gradient: FloatArray
    slope: FloatArray


@dataclass(frozen=True, eq=False)
class LipOpenings:
    """Nine distances between the inner lips of a person, down the face, as they are seen.

    Parameters
    ----------
    mean : (36, 3) float64, mm, head frame
        The upper lip's inner edge, the lower lip's, then the outer edges beside them.
    modes : (M, 36, 3) float64, mm per standard deviation
    normals : (18, 3) float64
        Of the outer edges.
    pivot : (3,) float64, mm
    apart : (9,) float64
        Distances seen, at depth 1.
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
    apart: FloatArray
    down: FloatArray
    trust: FloatArray
    bias: FloatArray
    pixel: float

    @classmethod
    def of(cls, shape: LandmarkShape, seen: SeenRays) -> LipOpenings:
        """The distances of a frame's landmarks on a person's head."""
        points, down = np.concatenate([_UPPER, _LOWER, _BESIDE]), seen.axes[1]
        return cls(
            shape.mean[points],
            np.ascontiguousarray(shape.posture[:, points]),
            shape.normals[_BESIDE],
            shape.pivot,
            (seen.rays[_LOWER] - seen.rays[_UPPER]) @ down,
            down,
            np.minimum(seen.trust[_LOWER], seen.trust[_UPPER]),
            shape.bias[_LOWER, 1] - shape.bias[_UPPER, 1],
            seen.pixel,
        )

    def equations(self, pose: Pose, posture: FloatArray) -> OpeningEquations:
        """Linearise the distances in a pose and posture (M,).

        Each counts less where the lips beside it are hidden, or where it is far off (Cauchy).
        """
        moved = posture @ self.modes.reshape(len(posture), self.mean.size)
        there = pose.apply(self.mean + moved.reshape(self.mean.shape))
        distance = float(pose.apply(self.pivot)[2])
        rays = there[: 2 * _PLACES, :2] / there[: 2 * _PLACES, 2:]
        drawn = (rays[_PLACES:] - rays[:_PLACES]) @ self.down
        off = (drawn - self.apart) * distance + self.bias
        variance = self._variance(distance)
        shown = in_view(self.normals, pose, there[2 * _PLACES :]).reshape(2, _PLACES).min(axis=0)
        stray = 1 + off**2 / (LANDMARK_EVIDENCE.stray**2 * variance)
        weight = self.trust * shown / (stray * variance * LANDMARK_EVIDENCE.openings_together)
        moves = self._motion(pose, there[: 2 * _PLACES], rays, distance)
        return _equations(*moves, weight, off)

    def _variance(self, distance: float) -> FloatArray:
        """Of each distance, mm2, of a head that is this far away, mm."""
        fixed = LANDMARK_EVIDENCE.opening_least**2
        fixed += (LANDMARK_EVIDENCE.opening_pixels * self.pixel * distance) ** 2
        apart = np.maximum(self.apart * distance, 0.0)
        return np.asarray(fixed + (LANDMARK_EVIDENCE.opening_share * apart) ** 2)

    def _motion(
        self, pose: Pose, there: FloatArray, rays: FloatArray, distance: float
    ) -> tuple[FloatArray, FloatArray]:
        """How each mode moves the lips apart (M, 9), mm, and what of it goes with their depth.

        That is the part along how modes move the upper and the lower lip in depth.
        """
        moved = self.modes[:, : 2 * _PLACES] @ pose.rotation.T
        seen = (moved[..., :2] - moved[..., 2:] * rays) @ self.down * (distance / there[:, 2])
        moves = seen[:, _PLACES:] - seen[:, :_PLACES]
        depths = moved[..., 2].reshape(len(moved), 2, _PLACES).mean(axis=2)
        own = depths.T @ depths + _LEAST_DEPTH**2 * np.eye(2)
        return moves, depths @ np.linalg.solve(own, depths.T @ moves)


def _equations(
    moves: FloatArray, along: FloatArray, weight: FloatArray, off: FloatArray
) -> OpeningEquations:
    """Equations of distances that modes change by `moves` (M, 9), `along` their lips' depth.

    A posture that opens the mouth as far without pushing a lip forward explains a distance as well.
    So a share of each distance's weight leaves the depth out.
    """
    flat, share = moves - along, LANDMARK_EVIDENCE.opening_depth
    information = (1 - share) * (moves * weight) @ moves.T + share * (flat * weight) @ flat.T
    pull = (moves - share * along) * weight
    return OpeningEquations(information, pull @ off, pull @ moves.T)
