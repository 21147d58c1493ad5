"""A head and the frames it is fitted to: what is looked for, and what was found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.tracking.detection.landmarks import Landmarks
from abs_engine.tracking.landmark.head_equations import HeadGuess
from abs_engine.tracking.landmark.landmark_noise import LandmarkNoise
from abs_engine.tracking.landmark.landmark_shape import LandmarkShape
from abs_engine.tracking.texture.head_texture import Gray, HeadBody, HeadView


@dataclass(frozen=True, eq=False)
class HeadFrameSeen:
    """Observations that a frame gives of a head.

    Parameters
    ----------
    gray : (H, W) uint8
    pupils : (2, 2) float64, px, or None
    image : (H, W, 3) uint8 RGB, optional
        Without it the head's outline is not looked at.
    """

    gray: Gray
    landmarks: Landmarks
    pupils: FloatArray | None
    image: NDArray[np.uint8] | None = None


@dataclass(frozen=True, eq=False)
class JointHead:
    """Identity of a person, and the head's pose in each frame.

    Parameters
    ----------
    identity : (K,) float64
    error : (Q,) float64
        The network's error of this person.
    postures : (N, M) float64
    """

    identity: FloatArray
    error: FloatArray
    poses: tuple[Pose, ...]
    postures: FloatArray

    def guess(self, k: int) -> HeadGuess:
        """Estimate for a frame."""
        return HeadGuess(self.poses[k], self.identity, self.error, self.postures[k])


@dataclass(frozen=True, eq=False)
class HeadProblem:
    """Parameters and observations of the fit.

    Parameters
    ----------
    pupils : tuple of two (N,) int
        Vertices about the right and the left pupil.
    apart : float, mm
        Distance of the pupils.
    held : float, mm
        Its standard deviation.
    """

    body: HeadBody
    shape: LandmarkShape
    noise: LandmarkNoise
    pupils: tuple[NDArray[np.integer], NDArray[np.integer]]
    apart: float
    held: float
    camera: Camera

    @property
    def known(self) -> bool:
        """Whether the head is the person's own."""
        return len(self.shape.identity) == 0

    @property
    def sizes(self) -> tuple[int, int, int]:
        """Numbers of identity modes, of the person's errors, and of posture modes."""
        return len(self.shape.identity), len(self.noise.between), len(self.shape.posture)

    def eyes(self, identity: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The pupils (2, 3) of a person, and how they move (K, 2, 3)."""
        modes = np.stack([self.body.identity[:, v].mean(axis=1) for v in self.pupils], axis=1)
        mean = np.stack([self.body.mean[v].mean(axis=0) for v in self.pupils])
        return mean + np.tensordot(identity, modes, 1), modes


def views_of(body: HeadBody, frames: Sequence[HeadFrameSeen], head: JointHead) -> list[HeadView]:
    """The frames as they show the head."""
    heads = body.of_person(head.identity, head.postures)
    return [
        HeadView.of(f.gray, p, x, body.speaker.faces)
        for f, p, x in zip(frames, head.poses, heads, strict=True)
    ]
