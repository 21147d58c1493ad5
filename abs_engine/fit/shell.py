"""One frame as an objective over the shell of learned physics (Basu et al., 5.3 to 5.5)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from abs_engine.compare.facets import FacetLikelihood
from abs_engine.compare.forces import Rule as Integral
from abs_engine.compare.mixture_prior import MixturePrior
from abs_engine.compare.prior import GaussianPrior
from abs_engine.compare.pull import Pull, PullRule
from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.blocks import Blocks
from abs_engine.core.camera import Camera, Window
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import POSE_NAMES, PoseFrame, free_blocks, joined, mode_block, pose_and
from abs_engine.core.scene import Candidates, ClassMaps, Renderer, Scene
from abs_engine.face.appearance.chroma import sampled
from abs_engine.face.appearance.colour import ColourClasses
from abs_engine.face.appearance.colour_features import CLASSES
from abs_engine.face.appearance.hamming import hamming
from abs_engine.face.shape.lip_model import COLOUR_OF, LIPS, LipModel
from abs_engine.face.shape.lip_shell import COLUMNS
from abs_engine.fit.evidence import Term
from abs_engine.fit.head_frame import COLOUR, window_of, zone
from abs_engine.fit.problem import Problem
from abs_engine.fit.settings import HEAD_FIT, SHELL_FIT

POSE_FREE = np.array(SHELL_FIT.pose_free)


@dataclass(frozen=True, eq=False)
class ShellSetting:
    """Values that stay the same over the frames.

    Parameters
    ----------
    scene : Scene
        Of the model.
    pose_deviation : (6,) float64 or None
        Standard deviations of the pose about the given one, rad and mm; None if it is known.
    score : {"exact", "sample"}
        How the posterior is integrated over a facet: see `FacetLikelihood`.
    seen : (K, P) float64, optional
        Shapes that were learned from, in standard deviations of the modes: what is probable is near
        one of them, see `MixturePrior`. By default the prior is eq. 10's one Gaussian.
    prior_width : float
        Factor of the prior's standard deviations, but for the pose.
    """

    model: LipModel
    scene: Scene
    classes: ColourClasses
    camera: Camera
    renderer: Renderer
    pose_deviation: FloatArray | None = None
    score: Integral = "exact"
    seen: FloatArray | None = None
    prior_width: float = 1.0

    @cached_property
    def border(self) -> FloatArray:
        """The lips' outer contour (34, 3) at rest, mm, head frame."""
        return np.asarray(self.model.physics.rest[2 * COLUMNS : 3 * COLUMNS])

    @property
    def free(self) -> tuple[str, ...]:
        """Blocks that are fitted."""
        return free_blocks(self.pose_deviation is None)

    @property
    def blocks(self) -> Blocks:
        """The pose, and the posture: the weights of the modes."""
        return pose_and(mode_block(self.model.n_modes, SHELL_FIT.mode_limit))


def shell_window(setting: ShellSetting, pose: Pose) -> Window:
    """The window around the lips: see `HEAD_FIT.window`, as seen from the front."""
    pixels = setting.camera.project(pose.apply(setting.border))
    return window_of(pixels, mouth_across(setting, pose), SHELL_FIT.drawn_mouth)


def mouth_across(setting: ShellSetting, pose: Pose) -> float:
    """Width of the mouth at rest as if seen from the front, pixels of the picture."""
    depth = pose.apply(setting.border)[:, 2].mean()
    return float(np.ptp(setting.border[:, 0]) * setting.camera.matrix[0, 0] / depth)


def shell_problem(setting: ShellSetting, image: Image, pose: Pose) -> Problem:
    """-log f(p|O) of a frame (H, W, 3) RGB, about a known or guessed pose; knows its forces."""
    return problem_of(setting, pose, {COLOUR: shell_colours(setting, image, pose)})


def problem_of(setting: ShellSetting, pose: Pose, terms: Mapping[str, Term]) -> Problem:
    """A frame of a shell, about a pose, by some terms.

    The forces on the nodes go through the learned inverse stiffness: U = S L^(1/2) S' F (eq. 13).
    In standard deviations of the modes that is S' F. A pose gives way by its variance.
    """
    frame = PoseFrame(pose, setting.border.mean(axis=0))
    free = setting.pose_deviation
    variance = np.zeros(len(POSE_NAMES)) if free is None else free**2
    return Problem(
        frame, setting.blocks, terms, (_prior(setting),), setting.free,
        mobility=joined(variance, 1 / setting.model.deviations),
    )  # fmt: skip


def shell_colours(
    setting: ShellSetting, image: Image, pose: Pose, rule: PullRule = "whole"
) -> FacetLikelihood:
    """The facet likelihood of a frame of a shell; `rule` is one of `compare.pull.PULL_RULES`."""
    window = shell_window(setting, pose)
    inside = zone(window)
    raw = setting.classes.probabilities(sampled(window, image))
    fine = _planes(hamming(raw, HEAD_FIT.smoothing * SHELL_FIT.drawn_mouth)) * inside
    wide = _planes(hamming(raw, HEAD_FIT.pull * SHELL_FIT.drawn_mouth))
    outside = np.clip(1 - fine[1] - fine[2], 0, 1) * inside
    wide[1:] -= np.clip(1 - wide[1] - wide[2], 0, 1)  # where nothing is drawn stays 0
    pixels = int(inside.sum())
    side = max(SHELL_FIT.side, SHELL_FIT.side_of_mouth * mouth_across(setting, pose)) * window.scale
    return FacetLikelihood(
        setting.renderer, setting.scene, setting.camera, window,
        ClassMaps(np.asarray(fine, np.float32)), pixels, pixels / side**2,
        np.asarray(outside, np.float32), setting.score, inside, Pull.within(wide, inside, rule),
    )  # fmt: skip


def _prior(setting: ShellSetting) -> GaussianPrior | MixturePrior:
    """Over all 6 + P parameters (eq. 10)."""
    free = setting.pose_deviation
    pose = np.ones(len(POSE_NAMES)) if free is None else free
    deviation = joined(pose, np.full(setting.model.n_modes, setting.prior_width))
    gaussian = GaussianPrior(np.zeros(len(deviation)), deviation)
    return (
        gaussian if setting.seen is None else MixturePrior(gaussian, setting.seen, SHELL_FIT.width)
    )


def _planes(probable: FloatArray) -> FloatArray:
    """One map for each facet class of the shell: none, skin, lips, and what the opening shows."""
    of = dict(zip(CLASSES, probable, strict=True))
    lips = of["lips"] + SHELL_FIT.in_shade * of["dark"]
    shown = {"skin": of["skin"], "lips": lips, "interior": of["teeth"] + of["dark"]}
    skin = of["skin"]
    return np.stack([np.zeros_like(skin) if c is None else shown[c] for c in COLOUR_OF])


def centred(
    setting: ShellSetting,
    pose: Pose,
    centre: NDArray[np.floating],
    weights: FloatArray,
    rounds: int = SHELL_FIT.placed,
) -> Pose:
    """The pose shifted across the line of sight to see the lips' centroid at a centre (2,), px.

    Section 5.3: the centroid of the visible area of the lips, as drawn with the weights (P,), is
    brought to that of the blob. Depth and rotation stay. It is drawn as often as there are
    `rounds`.
    """
    focal = np.array([setting.camera.matrix[0, 0], setting.camera.matrix[1, 1]])
    for _ in range(rounds):
        middle = pose.apply(setting.border).mean(axis=0)
        seen = _lip_centroid(setting, pose, weights)
        seen = setting.camera.project(middle) if seen is None else seen
        shift = (np.asarray(centre, np.float64) - seen) / focal * middle[2]
        pose = replace(pose, translation=pose.translation + np.r_[shift, 0.0])
    return pose


def _lip_centroid(setting: ShellSetting, pose: Pose, weights: FloatArray) -> FloatArray | None:
    """Centroid (2,), px, of the drawn lips; None if none are."""
    window = shell_window(setting, pose)
    candidate = Candidates.one(weights, pose)
    drawn = setting.renderer.draw(setting.scene, candidate, setting.camera, window)[0]
    rows, columns = np.nonzero(drawn.class_id == LIPS)
    if len(rows) == 0:
        return None
    return window.to_image(np.array([columns.mean(), rows.mean()]))
