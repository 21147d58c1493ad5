"""Relaxing the modal constraint: the full-rank shell settles on a moment (Basu et al., 6.1).

A moment is what one or more cameras saw at the same time. All of them pull on the one shell: where
it lies in depth, which a single view hardly shows, another view sees.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from abs_engine.compare.facets import FacetLikelihood
from abs_engine.compare.prior import GaussianPrior
from abs_engine.core.arrays import FloatArray
from abs_engine.core.blocks import POSTURE
from abs_engine.core.geometry import Pose
from abs_engine.core.objective import Evaluation
from abs_engine.core.params import ParamSpec
from abs_engine.core.pose import POSE_NAMES, PoseFrame, mode_block, pose_and
from abs_engine.face.shape.fem import ThinShell
from abs_engine.face.shape.lip_model import LipModel
from abs_engine.face.shape.modal import LearnedPhysics
from abs_engine.fit.head_frame import COLOUR
from abs_engine.fit.problem import Problem
from abs_engine.fit.settings import SHELL_FIT
from abs_engine.optimise.newton import Newton

_NEWTON = Newton(polished=0, limit=SHELL_FIT.relaxed_limit)


@dataclass(frozen=True, eq=False)
class Seen:
    """A moment as one camera saw it: its colours, and the head's pose, head to camera, held.

    The scene of `colours` is replaced by that of the shell.
    """

    colours: FacetLikelihood
    pose: Pose


@dataclass(frozen=True, eq=False)
class SharedShape:
    """-log posterior of a shape that several views share; their sum is minimised.

    The problems are over the posture alone; the prior is in one of them.
    """

    problems: tuple[Problem, ...]
    unit: float = 1.0

    @property
    def spec(self) -> ParamSpec:
        """Names, units, scales and bounds of the weights."""
        return self.problems[0].spec

    def __call__(self, x: FloatArray) -> Evaluation:
        """Value at weights (P,)."""
        return Evaluation(float(self.values(x[None])[0]), {})

    def values(self, vectors: FloatArray) -> FloatArray:
        """Values (B,) at weights (B, P), nats."""
        return np.asarray(np.sum([p.values(vectors) for p in self.problems], axis=0))

    def newton(
        self, x: FloatArray, reach: int, local: bool = False
    ) -> tuple[float, FloatArray, FloatArray]:
        """Value, gradient (P,) and second derivative (P, P) at `x`; see `Problem.newton`."""
        made = [p.newton(x, reach, local) for p in self.problems]
        values, slopes, curves = zip(*made, strict=True)
        return sum(values), np.sum(slopes, axis=0), np.sum(curves, axis=0)

    def information(self, x: FloatArray) -> FloatArray:
        """Information (P, P) of all views and the prior about the weights at `x` (P,)."""
        found = [p.information(x) for p in self.problems]
        return np.asarray(np.sum([f for f in found if f is not None], axis=0))


@dataclass(frozen=True, eq=False)
class Settled:
    """A shape that was found in a moment.

    Parameters
    ----------
    moved : (N, 3) float64, mm
        The shell's displacement from rest.
    weights : (P,) float64
        In standard deviations of the modes.
    covariance : (P, P) float64
        Of the weights, by Laplace's approximation; the prior's own is the identity.
    value : float, nats
        -log posterior.
    """

    moved: FloatArray
    weights: FloatArray
    covariance: FloatArray
    value: float

    @property
    def evidence(self) -> float:
        """-log probability of the pictures, nats: the posterior integrated over the weights.

        By Laplace's approximation and up to what is the same for all physics. A model that could
        be anywhere pays for it.
        """
        return float(self.value - 0.5 * np.linalg.slogdet(self.covariance)[1])


def softness(elastic: ThinShell, typical: float) -> float:
    """T of the prior N(0, T K^-1) under which nodes move by `typical` mm RMS, mm N."""
    rows = elastic.compliance_rows(np.arange(3 * len(elastic.vertices)))
    return float(typical**2 / (np.trace(rows) / len(elastic.vertices)))


def relaxed(
    physics: LearnedPhysics, elastic: ThinShell, temperature: float, count: int
) -> LearnedPhysics:
    """Physics whose shell may leave the modes as far as its elasticity lets it.

    `elastic` is the shell with its first, unlearned stiffness K; the temperature T is how far it
    may strain, see `softness`. The modes are the leading `count` of S L S' + T K^-1, the covariance
    of a shape of the modes to which an elastic displacement is added.
    """
    free = temperature * elastic.solve(np.eye(3 * len(physics.rest)))
    modal = physics.matrix * physics.deviations
    values, vectors = np.linalg.eigh(0.5 * (free + free.T) + modal @ modal.T)
    kept = vectors[:, ::-1][:, :count].T.reshape(count, *physics.rest.shape)
    none = np.zeros(0)
    return replace(
        physics, modes=np.ascontiguousarray(kept), variances=values[::-1][:count].copy(),
        total=float(values.sum()), noise_variances=none, motion_variances=none,
    )  # fmt: skip


def shared_shape(model: LipModel, views: Sequence[Seen]) -> SharedShape:
    """Objective over a model's weights for one moment, seen by one view or more."""
    scene = model.scene()
    blocks = pose_and(mode_block(model.n_modes, SHELL_FIT.mode_limit))
    pivot = model.physics.rest.mean(axis=0)
    size = len(POSE_NAMES) + model.n_modes
    prior = GaussianPrior(np.zeros(size), np.ones(size))
    return SharedShape(
        tuple(
            Problem(
                PoseFrame(view.pose, pivot), blocks, {COLOUR: replace(view.colours, scene=scene)},
                () if k else (prior,), (POSTURE,),
            )
            for k, view in enumerate(views)
        )
    )  # fmt: skip


def settle(model: LipModel, views: Sequence[Seen], starts: FloatArray) -> Settled:
    """The most probable shape of a moment, from several starts (K, P), of which the best few count.

    The model's physics is what it may move by: learned, or `relaxed`.
    """
    problem = shared_shape(model, views)
    best = starts[np.argsort(problem.values(starts), kind="stable")[: SHELL_FIT.tried]]
    ends = [_NEWTON.minimise(problem, start, problem.spec) for start in best]
    end = min(ends, key=lambda e: e.value)
    size, axes = np.linalg.eigh(problem.information(end.x))
    covariance = (axes / np.maximum(size, 1.0)) @ axes.T  # no view takes from what a prior says
    physics = model.physics
    moved = physics.shape(end.x * physics.deviations) - physics.rest
    return Settled(moved, end.x, covariance, end.value)
