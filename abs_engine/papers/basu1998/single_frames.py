"""The shell fitted to single frames, each by itself, from many starts (sections 5.3 to 5.5)."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.cluster.vq import kmeans2

from abs_engine.compare.facets import FacetLikelihood
from abs_engine.compare.pull import pull_rule
from abs_engine.core.blocks import POSTURE
from abs_engine.core.camera import Window
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Candidates
from abs_engine.face.shape.lip_model import LIPS
from abs_engine.face.shape.modal import LearnedPhysics
from abs_engine.fit.centroid import centred
from abs_engine.fit.head_frame import COLOUR
from abs_engine.fit.problem import Problem
from abs_engine.fit.search import Minimiser, several
from abs_engine.fit.shell import Image, ShellSetting, shell_problem
from abs_engine.optimise.ascent import FixedStep, Forces, Gradient
from abs_engine.optimise.base import Solution
from abs_engine.optimise.simplex import Simplex

FloatArray = NDArray[np.float64]
STARTS = 48
TRIED = 4
"""Best of the starts that are all gone on with: what was seen makes several maxima."""
EXPLAINED, LIPS_SHOWN = 0.5, 0.3
"""What is found explains at least so much, its lips by themselves too, or no mouth is there."""
ITERATIONS = 15
"""Within so many iterations the paper's example converges."""


DRIVERS: dict[str, Minimiser] = {
    "forces": Forces(limit=ITERATIONS),
    "gradient": Gradient(limit=ITERATIONS),
    "simplex": Simplex(),
}
AS_PRINTED = "fixed step"
_EVERY: dict[str, Minimiser] = {**DRIVERS, AS_PRINTED: FixedStep(limit=ITERATIONS)}


@dataclass(frozen=True, eq=False)
class ShellFit:
    """What was found in a frame: the mean of several maxima by their probability.

    Parameters
    ----------
    weights : (P,) float64
        In standard deviations of the modes.
    pose : Pose
        Head to camera.
    nodes : (N, 3) float64, mm, head frame
        Of the shell.
    highest : (N, 3) float64, mm, head frame
        The same of the highest maximum alone.
    solution : Solution
        The highest maximum: what the search from one of the starts came to. Evaluations include
        those from all starts; iterations are those from its own.
    seconds : float
    explained : float
        Mean probability of the drawn classes over the compared pixels, 0 to 1.
    found : bool
        Whether a mouth was there: if not, half of it lay outside of the picture, it explains less
        than `EXPLAINED`, or what is drawn as lips is lips by less than `LIPS_SHOWN`, and the other
        numbers say nothing.
    """

    weights: FloatArray
    pose: Pose
    nodes: FloatArray
    highest: FloatArray
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
        One of `DRIVERS`, or `AS_PRINTED`.
    rule : str
        How forces are found, see `compare.pull.PULL_RULES`.
    centre : (2,) float64, px, optional
        Of the lips' blob: every start is first placed there (section 5.3).

    Raises
    ------
    ParameterError
        If there is no such driver or rule, or a centre is given for a pose that is known.
    """
    _check_driver(driver)
    pull_rule(rule)
    if centre is not None and setting.pose_deviation is None:
        raise ParameterError("a centre is given for a known pose", "let the pose be fitted")
    begun = time.perf_counter()
    if centre is not None:
        pose = centred(setting, pose, centre)
    problem = shell_problem(setting, image, pose, pull_rule(rule))
    full = np.stack([problem.blocks.vector({POSTURE: start}) for start in starts])
    if centre is not None:
        full[:, 3:6] = [_shift(setting, pose, centre, start) for start in starts]
    vectors = problem.chosen(full)
    ends = several(problem, vectors, _EVERY[driver], TRIED)
    spent = len(starts) + sum(end.n_evaluations for end in ends) + 1
    best = replace(min(ends, key=lambda end: end.value), n_evaluations=spent)
    mean = mean_of(ends)
    shape = problem.part(mean, POSTURE)
    nodes, highest = (
        setting.scene.vertices(weights)[: len(setting.model.shell)]
        for weights in (shape, problem.part(best.x, POSTURE))
    )
    colours = colours_of(problem)
    explained, of_lips = _shown(colours, problem.candidates(mean[None]))
    inside = _share_inside(colours.window, setting.camera.size)
    there = explained >= EXPLAINED and of_lips >= LIPS_SHOWN and inside >= 0.5
    seconds = time.perf_counter() - begun
    return ShellFit(shape, problem.pose(mean), nodes, highest, best, seconds, explained, there)


def colours_of(problem: Problem) -> FacetLikelihood:
    """The colours' likelihood of a shell's problem."""
    term = problem.terms[COLOUR]
    if not isinstance(term, FacetLikelihood):
        raise TypeError("the problem's colours are no facet likelihood")
    return term


def _check_driver(driver: str) -> None:
    if driver not in _EVERY:
        raise ParameterError(f"there is no driver '{driver}'", f"choose of {', '.join(DRIVERS)}")


def mean_of(ends: Sequence[Solution]) -> FloatArray:
    """The mean (N,) of several ends by the probability that each has.

    Where the picture leaves several shapes about as probable, no choice of one of them is off less
    on the average than their mean. Only the height of each maximum counts, not how wide it is.
    """
    lowest = min(end.value for end in ends)
    weight = np.exp([lowest - end.value for end in ends])
    return np.asarray(weight @ np.stack([end.x for end in ends]) / weight.sum())


def _shown(like: FacetLikelihood, candidates: Candidates) -> tuple[float, float]:
    """Mean probability of the drawn classes, of all compared pixels and of those of the lips.

    A picture of skin alone is well explained by a mouth whose lips are small.
    """
    explained = np.exp(-float(like.negative_log(candidates)[0]) / like.observations)
    drawn = like.renderer.draw(like.scene, candidates, like.camera, like.window)[0]
    lips = drawn.class_id == LIPS
    if like.compared is not None:
        lips &= like.compared
    return float(explained), float(like.maps.maps[LIPS][lips].mean()) if lips.any() else 0.0


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
