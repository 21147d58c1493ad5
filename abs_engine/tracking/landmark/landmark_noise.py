"""The landmark network's errors: common to all, of each person, and of each frame.

Its errors are not independent: a whole jaw is seen too low, or a face too wide. What they have in
common is a factor analysis of drawn heads whose landmarks are known; where it is left out, a fit
takes the network's errors for the pose and the person.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.io.arrays import Layout, real
from abs_engine.tracking.detection.landmarks import COUNT, SeenRays
from abs_engine.tracking.settings.landmarks import LANDMARK_EVIDENCE

LAYOUT: Layout = {
    "noise_bias": real(COUNT, 3),
    "noise_between": real("Q*", COUNT, 3),
    "noise_within": real("R*", COUNT, 3),
    "noise_deviation": real(COUNT, 3, low=1e-9),
    "noise_person_deviation": real(COUNT, 3, low=0.0),
}
"""Its arrays in a file."""


@dataclass(frozen=True, eq=False)
class LandmarkNoise:
    """Errors of the network at the head, mm: along the eyes, down the face, in depth.

    Parameters
    ----------
    bias : (468, 3) float64
        Its mean error.
    between : (Q, 468, 3) float64
        Factors of a person's own error: one standard deviation each.
    within : (R, 468, 3) float64
        Factors of a frame's own error.
    deviation : (468, 3) float64
        Standard deviation of what the factors leave of a frame.
    person_deviation : (468, 3) float64
        The same of a person.
    """

    bias: FloatArray
    between: FloatArray
    within: FloatArray
    deviation: FloatArray
    person_deviation: FloatArray

    @cached_property
    def whole(self) -> FloatArray:
        """Variance of a frame's errors with what they have in common (468, 3), mm^2."""
        return np.asarray(self.variance + (self.within**2).sum(axis=0))

    @cached_property
    def variance(self) -> FloatArray:
        """Of what no factor explains (468, 3), mm^2."""
        return np.asarray(self.deviation**2 + self.person_deviation**2)

    def beside(self, moves: FloatArray) -> LandmarkNoise:
        """Less trust in landmarks that postures (M, 468, 3), mm, move: people move them otherwise.

        A jaw that opens wider than the postures' prior allows would nod the head.
        """
        far = LANDMARK_EVIDENCE.posture_share * np.sqrt((moves**2).sum(axis=(0, 2)))[:, None]
        return replace(self, deviation=np.hypot(self.deviation, far))

    def person(self, weights: FloatArray) -> LandmarkNoise:
        """Of a person whose own error is known, by weights (Q,) of `between`."""
        bias = self.bias + np.tensordot(weights, self.between, 1)
        none = np.zeros_like(self.person_deviation)
        return replace(self, bias=bias, between=self.between[:0], person_deviation=none)

    def arrays(self) -> dict[str, NDArray[np.float16]]:
        """As they are kept in a file."""
        return {f"noise_{k}": np.asarray(getattr(self, k), np.float16) for k in _NAMES}

    @classmethod
    def of_arrays(cls, data: Mapping[str, Any]) -> LandmarkNoise:
        """From a file's arrays, which are as `LAYOUT` says."""
        return cls(**{k: data[f"noise_{k}"] for k in _NAMES})


_NAMES = [one.name for one in fields(LandmarkNoise)]


def seen_off(there: FloatArray, seen: SeenRays) -> FloatArray:
    """By how much (468, 3), mm, landmarks are seen off the points (468, 3), mm, camera frame."""
    z = there[:, 2]
    across = (seen.rays - there[:, :2] / z[:, None]) * z.mean() @ seen.axes.T
    deep = seen.depth * z.mean() - z
    return np.column_stack([across, deep - deep.mean()])


def learn_noise(off: FloatArray, people: NDArray[np.int_]) -> LandmarkNoise:
    """The noise by errors (N, 468, 3) in pictures of several people (N,), numbered."""
    _, person = np.unique(people, return_inverse=True)
    flat = off.reshape(len(off), -1)
    bias = flat.mean(axis=0)
    count = int(person.max()) + 1
    means = np.stack([(flat[person == k] - bias).mean(axis=0) for k in range(count)])
    left = flat - bias - means[person]
    within, deviation = _factors(left, LANDMARK_EVIDENCE.factors_within, len(left) - count)
    between, own = _factors(means, LANDMARK_EVIDENCE.factors_between, count)
    return LandmarkNoise(
        bias.reshape(COUNT, 3),
        between,
        within,
        np.maximum(deviation, LANDMARK_EVIDENCE.least_noise),
        np.maximum(own, LANDMARK_EVIDENCE.least_noise),
    )


def _factors(rows: FloatArray, most: int, degrees: int) -> tuple[FloatArray, FloatArray]:
    """Principal factors (Q, 468, 3) of rows, and the deviation (468, 3) that they leave."""
    _, values, axes = np.linalg.svd(rows, full_matrices=False)
    variance = values**2 / max(degrees, 1)
    kept = min(most, len(variance) - 1)
    noise = variance[kept:].sum() / rows.shape[1]
    scale = np.sqrt(np.maximum(variance[:kept] - noise, 0.0))
    factors = axes[:kept] * scale[:, None]
    left = (rows**2).sum(axis=0) / max(degrees, 1) - (factors**2).sum(axis=0)
    deviation = np.sqrt(np.maximum(left, 0.0))
    return factors.reshape(-1, COUNT, 3), deviation.reshape(COUNT, 3)
