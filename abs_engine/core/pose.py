"""Parameter vectors of the tracker: six of pose about a base pose, then the weights of a scene."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.blocks import POSE, POSTURE, Blocks
from abs_engine.core.geometry import Pose, rotations
from abs_engine.core.params import ParamSpec
from abs_engine.core.scene import Candidates
from abs_engine.core.settings import GENERAL

POSE_NAMES = ("rx", "ry", "rz", "tx", "ty", "tz")
_POSE = len(POSE_NAMES)
POSE_UNITS = ("rad", "rad", "rad", "mm", "mm", "mm")


@dataclass(frozen=True, eq=False)
class PoseFrame:
    """Small motions about a base pose, turning about a point near the mouth.

    Turning about the mouth instead of the head's centre keeps rotation and translation apart, so
    that a solver may move one without the other.

    Parameters
    ----------
    base : Pose
    pivot : (3,) float64, mm, head frame
    """

    base: Pose
    pivot: FloatArray

    def candidates(self, vectors: FloatArray, weights: FloatArray | None = None) -> Candidates:
        """Candidates of parameter vectors (B, 6 + P), rotation and translation in camera axes.

        `weights` (B, P') are used in place of the vectors' own.
        """
        turned = rotations(vectors[:, :3]) @ self.base.rotation
        centre = self._centre + vectors[:, 3:6]
        shift = centre - turned @ self.pivot
        return Candidates(vectors[:, 6:] if weights is None else weights, turned, shift)

    @cached_property
    def _centre(self) -> FloatArray:
        """Place of the pivot at the base pose, (3,)."""
        return self.base.apply(self.pivot)

    def pose(self, vector: FloatArray) -> Pose:
        """The pose of one parameter vector (6 or more)."""
        one = self.candidates(vector[None, :6])
        return Pose(one.rotations[0], one.translations[0])


def at_base(weights: FloatArray) -> FloatArray:
    """Parameter vectors (..., 6 + P) of weights (..., P) at the base pose itself."""
    return np.concatenate([np.zeros((*weights.shape[:-1], _POSE)), weights], axis=-1)


def no_correction() -> FloatArray:
    """The correction (6,) that leaves a pose as it is."""
    return np.zeros(_POSE)


def joined(pose: FloatArray, weights: FloatArray) -> FloatArray:
    """Parameter vectors (..., 6 + P) of poses' corrections (..., 6) and weights (..., P)."""
    return np.concatenate([pose, weights], axis=-1)


def parted(vector: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A pose's correction (..., 6) and weights (..., P) of parameter vectors (..., 6 + P)."""
    return vector[..., :_POSE], vector[..., _POSE:]


def pose_moves(arms: FloatArray) -> FloatArray:
    """Motion of points for a step of the pose, rotation then translation, camera axes, (6, N, 3).

    `arms` (N, 3), mm, lead to them from the point that the pose turns about, camera axes.
    """
    moves = np.zeros((_POSE, *arms.shape))
    for axis in range(3):
        one, other = (axis + 1) % 3, (axis + 2) % 3
        moves[axis, ..., one], moves[axis, ..., other] = -arms[..., other], arms[..., one]
        moves[3 + axis, ..., axis] = 1.0
    return moves


def pose_block() -> ParamSpec:
    """Names, units, first steps and bounds of the six numbers of a pose."""
    reach, scale = np.array(GENERAL.pose_reach), np.array(GENERAL.pose_step)
    return ParamSpec(POSE_NAMES, POSE_UNITS, scale, -reach, reach)


def mode_block(count: int, limit: float) -> ParamSpec:
    """The same of so many modes, in standard deviations, of which none goes beyond a limit."""
    names = tuple(f"shape{k + 1}" for k in range(count))
    reach = np.full(count, limit)
    return ParamSpec(names, ("sd",) * count, np.full(count, GENERAL.mode_step), -reach, reach)


def free_blocks(pose_held: bool) -> tuple[str, ...]:
    """Names of the blocks of a frame that are fitted."""
    return (POSTURE,) if pose_held else (POSE, POSTURE)


def pose_and(posture: ParamSpec) -> Blocks:
    """The blocks of a frame: the pose, then a posture."""
    return Blocks({POSE: pose_block(), POSTURE: posture})
