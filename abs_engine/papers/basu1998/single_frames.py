"""The shell fitted to single frames, each by itself, from many starts (sections 5.3 to 5.5)."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.cluster.vq import kmeans2

from abs_engine.compare.facets import FacetLikelihood
from abs_engine.compare.pull import PullRule, pull_rule
from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.blocks import POSTURE
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import mode_block
from abs_engine.face.base import RINGS, Body, Face
from abs_engine.face.shape.lip_model import COLOUR_OF
from abs_engine.face.shape.lip_shell import COLUMNS
from abs_engine.face.shape.modal import LearnedPhysics
from abs_engine.fit.head_frame import COLOUR
from abs_engine.fit.problem import Problem
from abs_engine.fit.search import Minimiser
from abs_engine.fit.settings import SHELL_FIT
from abs_engine.fit.shell import ShellSetting, shell_colours
from abs_engine.fit.terms import term_kinds
from abs_engine.fit.view import View
from abs_engine.optimise.ascent import FixedStep, Forces, Gradient
from abs_engine.optimise.base import Solution
from abs_engine.optimise.by_nlopt import Simplex
from abs_engine.tracking.frame.clip_setting import ClipSetting, FrameResult
from abs_engine.tracking.frame.external_poses import GivenMotion
from abs_engine.tracking.frame.frame_state import Follower, HeadFrame, Memory, Motion
from abs_engine.tracking.frame.mouth_landmarks import MouthLandmarks
from abs_engine.tracking.frame.shell_frame import ShellBinder
from abs_engine.tracking.loop import track
from abs_engine.tracking.results.frame_journal import FrameJournal, fingerprint

STARTS = 48
TRIED = 4
"""Best of the starts that are all gone on with: what was seen makes several maxima."""
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
    """Fit of a frame: the mean of several maxima by their probability.

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
        The highest maximum, over pose and posture. Evaluations include those from all starts;
        iterations are those from its own.
    seconds : float
        NaN where it was kept from before.
    explained : float
        Mean probability of the drawn classes over the compared pixels, 0 to 1.
    """

    frame: int
    weights: FloatArray
    pose: Pose
    nodes: FloatArray
    highest: FloatArray
    solution: Solution
    seconds: float
    explained: float = 1.0


def seen_shapes(physics: LearnedPhysics, displacements: FloatArray) -> FloatArray:
    """Shapes (T, P) of displacements (T, N, 3), mm, in standard deviations of the modes.

    What is likely of them under errors of observation.
    """
    shrunk = physics.deviations / physics.expected
    return np.asarray(physics.coefficients(physics.rest + displacements) * shrunk)


def typical_shapes(
    physics: LearnedPhysics, displacements: FloatArray, count: int = STARTS, seed: int = 0
) -> FloatArray:
    """Shapes (K, P) to start from: what the training frames cluster around, and the mean.

    Parameters
    ----------
    displacements : (T, N, 3) float64, mm
        Of the training frames.

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


class Clock:
    """Follows as another does, and remembers when it was done: then the fit begins."""

    def __init__(self, own: Follower) -> None:
        self._own, self.begun = own, 0.0

    def follower(self) -> Clock:
        """Follower of the blobs, which is this value itself."""
        return self

    def step(self, image: Image, memory: Memory) -> HeadFrame:
        """The next frame with the head's pose."""
        frame = self._own.step(image, memory)
        self.begun = time.perf_counter()
        return frame

    def finish(self) -> None:
        """Say that there are no more frames."""
        self._own.finish()


def fit_frames(
    setting: ShellSetting,
    pictures: Iterable[Image],
    motion: Motion,
    starts: FloatArray,
    driver: str = "forces",
    rule: str = "whole",
    judged: bool = True,
    kept: Path | None = None,
) -> Iterator[ShellFit]:
    """Fit frames, each by itself; those in which no mouth is found are left out.

    Parameters
    ----------
    motion : Motion
        Where the head is.
    starts : (K, P) float64
        Shapes that are compared first; the `TRIED` best are gone on with.
    driver : str
        One of `DRIVERS`, or `AS_PRINTED`.
    rule : str
        How forces are found, see `compare.pull.PULL_RULES`.
    judged : bool
        Whether a mouth may not be there; else everything found is believed.
    kept : Path, optional
        Journal of these fits, of which an interrupted run did the first.

    Raises
    ------
    ParameterError
        If there is no such driver or rule.
    """
    if driver not in _EVERY:
        raise ParameterError(
            f"there is no driver '{driver}'", f"choose one of {', '.join(DRIVERS)}"
        )
    clip = _clip(setting, motion, starts, driver, pull_rule(rule), judged)
    clock = Clock(motion.follower())
    own = kept and FrameJournal(kept, fingerprint((clip, driver, rule)), ends=True)
    with own or nullcontext() as journal:
        before = 0 if journal is None else journal.resumed
        for _, found in track(replace(clip, motion=clock), pictures, journal=journal):
            if found.highest is not None and found.pose is not None:
                took = time.perf_counter() - clock.begun
                seconds = took if found.index >= before else float("nan")
                yield _fit_of(setting, found, found.highest, found.pose, seconds)


def fit_frame(
    setting: ShellSetting,
    picture: Image,
    pose: Pose,
    starts: FloatArray,
    driver: str = "forces",
) -> ShellFit:
    """Fit one frame about a pose; parameters as of `fit_frames`, everything found is believed."""
    motion = GivenMotion((pose,))
    return next(fit_frames(setting, [picture], motion, starts, driver, judged=False))


def _fit_of(
    setting: ShellSetting, found: FrameResult, highest: Solution, pose: Pose, seconds: float
) -> ShellFit:
    """A frame as the loop leaves it, by the shell's nodes."""
    of = setting.blocks.part
    weights, count = of(found.vector, POSTURE), len(setting.model.shell)
    nodes, best = (setting.scene.vertices(w)[:count] for w in (weights, of(highest.x, POSTURE)))
    return ShellFit(found.index, weights, pose, nodes, best, highest, seconds, found.score)


def _clip(
    setting: ShellSetting,
    motion: Motion,
    starts: FloatArray,
    driver: str,
    rule: PullRule,
    judged: bool,
) -> ClipSetting:
    """Values that stay the same over frames that are fitted each by itself."""

    def colours(_face: Face, view: View) -> FacetLikelihood:
        return shell_colours(setting, view.image, view.frame.base, rule)

    face = replace(bare_face(setting), starts=starts, own_terms={COLOUR: colours})
    kinds = term_kinds((COLOUR,))
    marks = MouthLandmarks(setting.model.n_modes)
    binder = ShellBinder(setting, face, kinds, marks, TRIED, alone=True, judged=judged)
    rate = 25.0  # of no consequence: no frame knows of another
    return ClipSetting(face, setting.camera, setting.renderer, rate, motion, binder, _EVERY[driver])


def bare_face(setting: ShellSetting) -> Face:
    """The face of a shell alone, its contours by its own nodes."""
    half, scene = COLUMNS // 2, setting.scene
    around = np.rint(np.linspace(0, COLUMNS, 12, endpoint=False)).astype(np.int64)
    within = np.rint(np.linspace(0, half, 4, endpoint=False)).astype(np.int64)
    outer = np.arange(2 * COLUMNS, 3 * COLUMNS)
    rings = {
        "outer": outer,
        "upper": np.arange(half),
        "lower": np.arange(half, COLUMNS),
        "points": np.concatenate([outer[around], within, half + within]),
        "corners": outer[[0, half]],
    }
    lips = np.concatenate([rings[name] for name in RINGS]).astype(np.int32)
    body = Body(scene.mean, scene.modes, scene.faces, scene.facet_class, COLOUR_OF, lips)
    modes = setting.model.n_modes
    return Face(
        "shell", scene, mode_block(modes, SHELL_FIT.mode_limit), setting.border.mean(axis=0), rings,
        setting.border, np.zeros((1, modes)), COLOUR_OF, body,
    )  # fmt: skip


def colours_of(problem: Problem) -> FacetLikelihood:
    """The colours' likelihood of a shell's problem."""
    term = problem.terms[COLOUR]
    if not isinstance(term, FacetLikelihood):
        raise TypeError("the problem's colours are no facet likelihood")
    return term
