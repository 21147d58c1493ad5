"""Fitting the shell to frames: starts, drivers, and what came of it (sections 5.3 to 5.5)."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.cluster.vq import kmeans2

from abs_engine.camera import Window
from abs_engine.errors import ParameterError
from abs_engine.geometry import Pose
from abs_engine.optimise.ascent import Forces, Gradient
from abs_engine.optimise.base import Solution
from abs_engine.optimise.simplex import Simplex
from abs_engine.params import ParamSpec
from abs_engine.shape.modal import LearnedPhysics
from abs_engine.track.centroid import centred
from abs_engine.track.shell import (
    RULES,
    Image,
    ShellPosterior,
    ShellSetting,
    shell_posterior,
)

FloatArray = NDArray[np.float64]
STARTS = 48
TRIED = 4
"""Best of the starts that are all gone on with: what was seen makes several maxima. What is found
is their mean by probability, which is off less than the best of them."""
EXPLAINED = 0.5
"""What is found explains at least so much, or no mouth is there."""
ITERATIONS = 15
"""Within so many iterations the paper's example converges."""


class Driver(Protocol):
    """What moves the parameters until the posterior is best."""

    def minimise(self, objective: ShellPosterior, start: FloatArray, spec: ParamSpec) -> Solution:
        """Minimise from `start`."""
        ...


DRIVERS: dict[str, Driver] = {
    "forces": Forces(limit=ITERATIONS),
    "gradient": Gradient(limit=ITERATIONS),
    "simplex": Simplex(),
}


@dataclass(frozen=True, eq=False)
class ShellFit:
    """What was found in a frame.

    Parameters
    ----------
    weights : (P,) float64
        In standard deviations of the modes.
    pose : Pose
        Head to camera.
    nodes : (N, 3) float64, mm, head frame
        Of the shell.
    solution : Solution
        Evaluations include those of all starts; iterations are those from the one that ended best.
    seconds : float
    explained : float
        Mean probability of the drawn classes over the compared pixels, 0 to 1.
    found : bool
        Whether a mouth was there: if not, half of it lay outside of the picture or it explains less
        than `EXPLAINED`, and the other numbers say nothing.
    """

    weights: FloatArray
    pose: Pose
    nodes: FloatArray
    solution: Solution
    seconds: float
    explained: float = 1.0
    found: bool = True


def seen_shapes(physics: LearnedPhysics, displacements: FloatArray) -> FloatArray:
    """Shapes (T, P) of displacements (T, N, 3), mm, in standard deviations of the modes.

    What is likely of them under errors of observation.
    """
    shrunk = physics.deviations / physics.variances
    return np.asarray(physics.coefficients(physics.rest + displacements) * shrunk)


def typical_shapes(
    physics: LearnedPhysics, displacements: FloatArray, count: int = STARTS, seed: int = 0
) -> FloatArray:
    """Shapes (K, P) to start from: what the training frames cluster around, and the mean.

    Parameters
    ----------
    physics : LearnedPhysics
    displacements : (T, N, 3) float64, mm
        Of the training frames.
    count : int
    seed : int

    Returns
    -------
    (K, P) float64
        In standard deviations of the modes; the first is the mean.
    """
    seen = seen_shapes(physics, displacements)
    count = min(count, len(seen))
    centres = kmeans2(seen, count, seed=seed, minit="++", missing="warn")[0] if count > 1 else seen
    centres = centres[np.isfinite(centres).all(axis=1)]
    return np.vstack([np.zeros((1, seen.shape[1])), centres])


def fit_frame(
    setting: ShellSetting,
    image: Image,
    pose: Pose,
    starts: FloatArray,
    driver: str = "forces",
    rule: str = "whole",
    centre: FloatArray | None = None,
) -> ShellFit:
    """Fit one frame.

    Parameters
    ----------
    setting : ShellSetting
    image : (H, W, 3) uint8 RGB
    pose : Pose
        Known, or where to start.
    starts : (K, P) float64
        Shapes that are compared first; the `TRIED` best are gone on with.
    driver : str
        One of `DRIVERS`.
    rule : str
        How forces are found, see `track.shell.RULES`.
    centre : (2,) float64, px, optional
        Of the lips' blob: every start is first placed there (section 5.3).

    Raises
    ------
    ParameterError
        If there is no such driver or rule, or a centre is given for a pose that is known.
    """
    way = next((known for known in RULES if known == rule), None)
    if driver not in DRIVERS or way is None:
        raise ParameterError(
            f"there is no driver '{driver}' with rule '{rule}'",
            f"drivers are {', '.join(DRIVERS)}; rules {', '.join(RULES)}",
        )
    if centre is not None and setting.pose_deviation is None:
        raise ParameterError("a centre is given for a known pose", "let the pose be fitted")
    begun = time.perf_counter()
    if centre is not None:
        pose = centred(setting, pose, centre)
    posterior = shell_posterior(setting, image, pose, way)
    held = np.zeros((len(starts), len(setting.free) - starts.shape[1]))
    if centre is not None:
        held[:, 3:6] = [_shift(setting, pose, centre, start) for start in starts]
    vectors = np.hstack([held, starts])
    order = np.argsort(posterior.values(vectors))[:TRIED]
    ends = [DRIVERS[driver].minimise(posterior, vectors[k], setting.spec) for k in order]
    spent = len(starts) + sum(end.n_evaluations for end in ends) + 1
    found = replace(mean_of(posterior, ends), n_evaluations=spent)
    full = posterior.whole(found.x)
    nodes = setting.scene.vertices(full[6:])[: len(setting.model.shell)]
    like = posterior.likelihood
    explained = float(np.exp(-found.terms["likelihood"] / like.observations))
    seen = _share_inside(like.window, setting.camera.size)
    seconds = time.perf_counter() - begun
    there = explained >= EXPLAINED and seen >= 0.5
    return ShellFit(full[6:], posterior.frame.pose(full), nodes, found, seconds, explained, there)


def mean_of(posterior: ShellPosterior, ends: list[Solution]) -> Solution:
    """The best of several ends, moved to the mean of all of them by their probability.

    Where the picture leaves several shapes about as probable, their mean is off less than any one
    of them on the average, as the mean of a distribution is.

    Parameters
    ----------
    posterior : ShellPosterior
        What ends' values are -log of.
    ends : list of Solution

    Returns
    -------
    Solution
        The best one with the mean's `x`, `value` and `terms`.
    """
    best = min(ends, key=lambda end: end.value)
    weight = np.exp([best.value - end.value for end in ends])
    x = weight @ np.stack([end.x for end in ends]) / weight.sum()
    there = posterior(x)
    return replace(best, x=x, value=there.value, terms=there.terms)


def _shift(
    setting: ShellSetting, pose: Pose, centre: FloatArray, weights: FloatArray
) -> FloatArray:
    """Translation (3,), mm, that brings a shape's visible lips to a centre in the picture."""
    return centred(setting, pose, centre, weights, rounds=1).translation - pose.translation


def _share_inside(window: Window, size: tuple[int, int]) -> float:
    """Share of a window that lies in the picture."""
    across = min(window.x + window.width, size[0]) - max(window.x, 0.0)
    down = min(window.y + window.height, size[1]) - max(window.y, 0.0)
    return max(0.0, across) * max(0.0, down) / (window.width * window.height)
