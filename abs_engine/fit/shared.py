"""Several frames as one problem over what they share: who the person is, and how poses are off."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from abs_engine.compare.prior import GaussianPrior
from abs_engine.core.arrays import FloatArray
from abs_engine.core.blocks import IDENTITY, POSE, Blocks
from abs_engine.core.objective import Evaluation
from abs_engine.core.params import ParamSpec
from abs_engine.core.pose import POSE_NAMES, POSE_UNITS
from abs_engine.core.threads import in_threads
from abs_engine.fit.problem import Problem
from abs_engine.fit.settings import HEAD_FIT


def shared_blocks(pose: FloatArray, identity: FloatArray) -> Blocks:
    """Blocks of a correction of all poses (6,), radians and mm, and of the identity (Q,).

    They are given by their standard deviations.
    """
    names = tuple(f"person{k + 1}" for k in range(len(identity)))
    of_person = _spec(names, ("weight",) * len(identity), identity)
    return Blocks({POSE: _spec(POSE_NAMES, POSE_UNITS, pose), IDENTITY: of_person})


def _spec(names: tuple[str, ...], units: tuple[str, ...], deviation: FloatArray) -> ParamSpec:
    return ParamSpec(
        names,
        units,
        HEAD_FIT.shared_step * deviation,
        -HEAD_FIT.shared_reach * deviation,
        HEAD_FIT.shared_reach * deviation,
    )


@dataclass(frozen=True, eq=False)
class SharedProblem:
    """-log posterior of what frames share, while what is each frame's own is held.

    Parameters
    ----------
    frames : sequence of Problem
        Over pose, posture and identity.
    held : (K, 6 + P + Q) float64
        Where each frame stands; its identity is that which is sought.
    blocks : Blocks
        Pose and identity, see `shared_blocks`; the `prior` is over both.
    threads : int
        How many frames are evaluated at once; what is found is the same.
    """

    frames: Sequence[Problem]
    held: FloatArray
    blocks: Blocks
    prior: GaussianPrior
    threads: int = 1

    @property
    def spec(self) -> ParamSpec:
        """Names, units, scales and bounds of what is sought."""
        return self.blocks.spec

    def __call__(self, x: FloatArray) -> Evaluation:
        """Value and terms at a correction and an identity (6 + Q,)."""
        values: dict[str, float] = {}
        data = 0.0

        def of_frame(k: int) -> Mapping[str, float]:
            moved, vector = self._moved(k, x)
            return moved(vector).terms

        each = in_threads(of_frame, range(len(self.frames)), self.threads)
        for problem, found in zip(self.frames, each, strict=True):
            for name in problem.terms:
                values[name] = values.get(name, 0.0) + found[name]
                data += found[name]
        prior = self.prior.negative_log(x)
        return Evaluation(data + prior, {**values, "prior": prior})

    def newton(
        self, x: FloatArray, reach: int, local: bool = False
    ) -> tuple[float, FloatArray, FloatArray]:
        """Value, gradient (6 + Q,) and second derivative for a Newton step, as of `Problem.newton`.

        A correction moves a frame as a step of its own pose does, but for their turns' order.
        """
        value, slope = self.prior.negative_log(x), self.prior.slope(x)
        curve = self.prior.curvature(x)

        def of_frame(k: int) -> tuple[float, FloatArray, FloatArray]:
            moved, vector = self._moved(k, x)
            return moved.newton(vector, reach, local)

        each = in_threads(of_frame, range(len(self.frames)), self.threads)
        for problem, (cost, fall, bend) in zip(self.frames, each, strict=True):
            own = problem.blocks.indices((POSE, IDENTITY))
            value, slope = value + cost, slope + fall[own]
            curve = curve + bend[np.ix_(own, own)]
        return value, slope, curve

    def values(self, vectors: FloatArray) -> FloatArray:
        """Values (B,) at corrections and identities (B, 6 + Q)."""
        return np.array([self(x).value for x in vectors])

    def _moved(self, k: int, x: FloatArray) -> tuple[Problem, FloatArray]:
        """A frame with its base pose corrected, and where it stands."""
        problem, held = self.frames[k], self.held[k]
        base = problem.frame.pose(self.blocks.part(x, POSE))
        vector = held.copy()
        vector[problem.blocks.places[IDENTITY]] = self.blocks.part(x, IDENTITY)
        return replace(problem, frame=replace(problem.frame, base=base)), vector
