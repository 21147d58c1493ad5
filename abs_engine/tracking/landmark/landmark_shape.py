"""The landmarks of a head as a linear function of who it is and what it does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.tracking.detection.landmarks import INNER_RING, MIDDLES, Landmarks, SeenRays
from abs_engine.tracking.landmark.landmark_correspondence import Correspondence
from abs_engine.tracking.settings.landmarks import LANDMARK_EVIDENCE


@dataclass(frozen=True, eq=False)
class LandmarkShape:
    """The landmarks of a head as a linear function of who it is and what it does.

    Parameters
    ----------
    mean : (468, 3) float64, mm, head frame
    identity : (K, 468, 3) float64, mm per standard deviation
    posture : (M, 468, 3) float64, mm per standard deviation
        First the P modes of the mouth, then what moves the upper face.
    normals : (468, 3) float64
        Which way the surface faces.
    deviation : (468, 3) float64, mm
        See `Correspondence`.
    pivot : (3,) float64, mm
        About which the head turns.
    bias : (468, 2) float64, mm
        By how much the network sees this person's points off, along the eyes and down the face.
    """

    mean: FloatArray
    identity: FloatArray
    posture: FloatArray
    normals: FloatArray
    deviation: FloatArray
    pivot: FloatArray
    bias: FloatArray

    @cached_property
    def modes(self) -> FloatArray:
        """All modes (K + M, 468, 3), those of identity first."""
        return np.concatenate([self.identity, self.posture])

    @classmethod
    def of(
        cls,
        correspondence: Correspondence,
        vertices: FloatArray,
        normals: FloatArray,
        identity: NDArray[np.floating],
        posture: NDArray[np.floating],
        pivot: FloatArray,
    ) -> LandmarkShape:
        """The landmarks on a head (V, 3) with its normals, and its modes (K, V, 3), (M, V, 3)."""
        c = correspondence
        facing = c.of(normals)
        unit = facing / np.maximum(np.linalg.norm(facing, axis=1, keepdims=True), 1e-9)
        none = np.zeros((len(unit), 2))
        return cls(c.of(vertices), c.of(identity), c.of(posture), unit, c.deviation, pivot, none)

    def off(
        self, landmarks: Landmarks, camera: Camera, pose: Pose, posture: FloatArray
    ) -> FloatArray:
        """By how much (468, 2), mm at the head, landmarks are seen off a pose and posture (M,).

        Along the line of the eyes, and down the face.
        """
        seen = SeenRays.of(landmarks, camera)
        there = pose.apply(self.mean + np.tensordot(posture, self.posture, 1))
        depth = float(pose.apply(self.pivot)[2])
        return (seen.rays - there[:, :2] / there[:, 2:]) * depth @ seen.axes.T

    def known(self, moved: FloatArray, off: Sequence[FloatArray]) -> LandmarkShape:
        """The landmarks of a person whom other evidence has fitted in several frames.

        What the network errs alike in all of them is the person's bias, which it is not wrong by
        again; what is left of its noise is less. The person's points differ from `mean` by `moved`
        (468, 3), mm; `off` (468, 2), mm, is that of each frame, the one with the mouth least open
        first.
        """
        share = LANDMARK_EVIDENCE.bias_share * min(1.0, len(off) / LANDMARK_EVIDENCE.closest)
        bias = share * np.median(off, axis=0)
        closed = share * np.median(off[: LANDMARK_EVIDENCE.closest], axis=0)
        bias[INNER_RING] = _limited(closed)
        within = LANDMARK_EVIDENCE.within if len(off) >= LANDMARK_EVIDENCE.closest else 1.0
        deviation = self.deviation * np.array([within, within, 1.0])
        return replace(self, mean=self.mean + moved, bias=bias, deviation=deviation)


def _limited(bias: FloatArray) -> FloatArray:
    """The inner lips' part (20, 2) of a bias (468, 2), mm, shrunk where it parts them by too much.

    In a clip in which lips never meet, the network sees them farther apart than the fit does, which
    lags behind: that is no bias.
    """
    inner, (upper, lower) = bias[INNER_RING], bias[list(MIDDLES), 1]
    share = min(1.0, LANDMARK_EVIDENCE.most_parted / max(lower - upper, 1e-9))
    middle = inner.mean(axis=0)
    return np.asarray(middle + share * (inner - middle))


def in_view(normals: FloatArray, pose: Pose, there: FloatArray) -> FloatArray:
    """Visibility of points (N,), by which way their surface faces.

    `normals` (N, 3) are in the head's frame, the points, `there` (N, 3), mm, in the camera's.
    """
    sight = there / np.linalg.norm(there, axis=1, keepdims=True)
    facing = -(normals @ pose.rotation.T * sight).sum(axis=1)
    least = LANDMARK_EVIDENCE.hidden
    return np.asarray(np.clip((facing - least) / (1 - least), LANDMARK_EVIDENCE.guessed, 1.0))
