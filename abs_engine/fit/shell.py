"""One frame as an objective over the shell of learned physics (Basu et al., 5.3 to 5.5)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from abs_engine.compare.facets import FacetLikelihood
from abs_engine.compare.forces import Rule as Integral
from abs_engine.compare.forces import border_forces, facet_forces, lifted, node_forces, slopes
from abs_engine.compare.prior import GaussianPrior, MixturePrior
from abs_engine.core.camera import Camera, Window
from abs_engine.core.geometry import Pose
from abs_engine.core.objective import Evaluation
from abs_engine.core.params import ParamSpec
from abs_engine.core.pose import PoseFrame, pose_spec
from abs_engine.core.scene import Candidates, ClassMaps, Renderer, Scene
from abs_engine.face.appearance.chroma import sampled
from abs_engine.face.appearance.colour import CLASSES, ColourClasses, hamming
from abs_engine.face.shape.lip_model import COLOUR_OF, LipModel
from abs_engine.face.shape.lip_shell import COLUMNS
from abs_engine.fit.head_frame import SMOOTHING, zone

FloatArray = NDArray[np.float64]
Image = NDArray[np.uint8]
DRAWN_MOUTH = 92.0  # drawn pixels across the mouth
FINEST = 2.0  # drawn pixels for one of the picture, at most
SIDE = 2.0  # px: side of an independent observation, as pixels share their chroma two by two,
SIDE_OF_MOUTH = 0.04  # or in mouth widths, if that is more: over so much the errors of a shell last
WIDTH = 0.7  # of the prior about each shape that was seen, standard deviations
PULL = 0.06  # likewise of the forces: how far a boundary is felt
IN_SHADE = 0.25  # share of the probability of dark that lips get: they throw shade on each other
FIRST_STRIDE = 2.0  # mm that the node which moves most is first pushed by
Rule = Literal["whole", "exact", "sample"]
RULES: tuple[Rule, ...] = ("whole", "exact", "sample")
"""How forces are found: eq. 12's one sample for a facet; eq. 11 exactly; or the whole derivative of
the score, in which facets grow, too.
"""
POSE_FREE = np.array([0.05, 0.05, 0.05, 2.0, 2.0, 12.0])
"""Standard deviations, rad and mm, of a pose that is estimated along."""


@dataclass(frozen=True, eq=False)
class ShellSetting:
    """What stays the same over the frames.

    Parameters
    ----------
    model : LipModel
    scene : Scene
        Of the model.
    classes : ColourClasses
    camera : Camera
    renderer : Renderer
    pose_deviation : (6,) float64 or None
        Standard deviations of the pose about the given one, rad and mm; None if it is known.
    score : {"exact", "sample"}
        How the posterior is integrated over a facet: see `FacetLikelihood`.
    seen : (K, P) float64, optional
        Shapes that were learned from, in standard deviations of the modes: what is probable is near
        one of them, see `MixturePrior`. By default the prior is eq. 10's one Gaussian.
    """

    model: LipModel
    scene: Scene
    classes: ColourClasses
    camera: Camera
    renderer: Renderer
    pose_deviation: FloatArray | None = None
    score: Integral = "exact"
    seen: FloatArray | None = None

    @cached_property
    def border(self) -> FloatArray:
        """The lips' outer contour (34, 3) at rest, mm, head frame."""
        return np.asarray(self.model.physics.rest[2 * COLUMNS : 3 * COLUMNS])

    @property
    def free(self) -> NDArray[np.int64]:
        """Which of the 6 + P parameters are fitted."""
        first = 6 if self.pose_deviation is None else 0
        return np.arange(first, 6 + self.model.n_modes)

    @property
    def spec(self) -> ParamSpec:
        """Names, units, first steps and bounds of the fitted parameters."""
        return pose_spec(self.model.n_modes, 6.0).only(self.free)


def shell_window(setting: ShellSetting, pose: Pose) -> Window:
    """The window around the lips: 1.6 mouth widths, as seen from the front, and 1.25 high."""
    at = pose.apply(setting.border)
    pixels = setting.camera.project(at)
    across = mouth_across(setting, pose)
    scale = min(FINEST, DRAWN_MOUTH / across)
    size = np.ceil(np.array([1.6, 1.25]) * across * scale) / scale
    centre = 0.5 * (pixels.min(axis=0) + pixels.max(axis=0)) + [0.0, 0.08 * across]
    x, y = np.rint(centre - 0.5 * size)
    return Window(float(x), float(y), float(size[0]), float(size[1]), scale)


def mouth_across(setting: ShellSetting, pose: Pose) -> float:
    """Width of the mouth at rest as if seen from the front, pixels of the picture."""
    depth = pose.apply(setting.border)[:, 2].mean()
    return float(np.ptp(setting.border[:, 0]) * setting.camera.matrix[0, 0] / depth)


@dataclass(frozen=True, eq=False)
class Pull:
    """Widely smoothed maps that pull on the facets.

    Parameters
    ----------
    maps : (C, H, W) float64
        What a pixel gives to a facet of each class; 0 where pixels are not compared.
    slopes : (C, 2, H, W) float64
        Their gradients. Taken before the maps are cut off, or the window's edge would pull.
    """

    maps: FloatArray
    slopes: FloatArray


@dataclass(frozen=True, eq=False)
class ShellPosterior:
    """-log f(p|O) of one frame over the fitted parameters; knows its forces.

    Parameters
    ----------
    setting : ShellSetting
    frame : PoseFrame
    likelihood : FacetLikelihood
    prior : GaussianPrior or MixturePrior
        Over all 6 + P parameters.
    pull : Pull
        What the forces come from.
    rule : str
        One of `RULES`.
    """

    setting: ShellSetting
    frame: PoseFrame
    likelihood: FacetLikelihood
    prior: GaussianPrior | MixturePrior
    pull: Pull
    rule: Rule = "whole"

    def whole(self, vectors: FloatArray) -> FloatArray:
        """All parameters (..., 6 + P) of the fitted ones (..., N)."""
        out = np.zeros((*vectors.shape[:-1], len(self.prior.mean)))
        out[..., self.setting.free] = vectors
        return out

    def __call__(self, x: FloatArray) -> Evaluation:
        """Value and terms at `x` (N,)."""
        full = self.whole(x)
        data = float(self.likelihood.negative_log(self.frame.candidates(full[None]))[0])
        prior = self.prior.negative_log(full)
        return Evaluation(data + prior, {"likelihood": data, "prior": prior})

    def values(self, vectors: FloatArray) -> FloatArray:
        """Values (B,) at vectors (B, N), drawn in one call."""
        full = self.whole(vectors)
        data = self.likelihood.negative_log(self.frame.candidates(full))
        return np.asarray(data + [self.prior.negative_log(x) for x in full], np.float64)

    def push(self, x: FloatArray) -> FloatArray:
        """Where the forces at `x` (N,) push the parameters: eq. 13, and the pose's own work.

        The forces on the nodes go through the learned inverse stiffness: U = S L^(1/2) S' F. In
        standard deviations of the modes that is S' F. The prior's slope counts as a force on the
        modes. Alpha is such that no node is first pushed farther than `FIRST_STRIDE`. A pose is
        pushed by its work times its variance, and pulled back by its prior.
        """
        full = self.whole(x)
        forces, candidate = self.node_forces(full)
        rotation, vertices = candidate.rotations[0], self.setting.scene.vertices(full[6:])
        modes = self.setting.scene.modes.astype(np.float64)
        work = np.tensordot(modes, forces @ rotation, ([1, 2], [0, 1]))
        gain = self.gain(float(self.likelihood.negative_log(candidate)[0]))
        felt = gain * work - self.prior.slope(full)[6:]
        step = felt / self.setting.model.deviations
        step = strided(step, np.tensordot(step, modes, 1))
        if self.setting.pose_deviation is None:
            return step
        arm = (vertices - self.frame.pivot) @ rotation.T
        pose_work = gain * np.r_[np.cross(arm, forces).sum(axis=0), forces.sum(axis=0)]
        pose = self.setting.pose_deviation**2 * pose_work - full[:6]
        pose = shortened(pose, np.cross(pose[:3], arm) + pose[3:])
        return np.asarray(np.r_[pose, step], np.float64)

    def node_forces(self, full: FloatArray) -> tuple[FloatArray, Candidates]:
        """Forces (V, 3) of eqs. 11 and 12 on the vertices, camera frame, and what was drawn."""
        candidate = self.frame.candidates(full[None])
        forces = scene_forces(self.likelihood, candidate, self.pull, self.rule)
        return forces, candidate

    def gain(self, data: float) -> float:
        """Derivative of log f(O|p) by the summed score, where -log f is `data`."""
        n = self.likelihood.observations
        return float(n / (np.exp(-data / n) * self.likelihood.pixels))


def scene_forces(
    likelihood: FacetLikelihood, candidate: Candidates, pull: Pull, rule: Rule
) -> FloatArray:
    """Forces (V, 3), camera frame, of a pull on one candidate's vertices."""
    like, scene = likelihood, likelihood.scene
    drawn = like.renderer.draw(scene, candidate, like.camera, like.window)[0]
    points = scene.vertices(candidate.weights[0]) @ candidate.rotations[0].T
    points = points + candidate.translations[0]
    if rule == "whole":
        flat = border_forces(drawn, pull.maps, scene.faces, len(points))
    else:
        flat = facet_forces(drawn, pull.slopes, scene.facet_class, rule)
        flat = node_forces(flat, scene.faces, len(points))
    return lifted(flat, points, like.camera, like.window.scale)


def strided(step: FloatArray, moved: FloatArray) -> FloatArray:
    """A step, scaled so that the node that moves most (V, 3) moves by `FIRST_STRIDE`."""
    farthest = float(np.linalg.norm(moved, axis=1).max())
    return np.asarray(step * (FIRST_STRIDE / max(farthest, 1e-9)))


def shortened(step: FloatArray, moved: FloatArray) -> FloatArray:
    """A step, shortened where a node moves (V, 3) farther than `FIRST_STRIDE`."""
    farthest = float(np.linalg.norm(moved, axis=1).max())
    return np.asarray(step * min(1.0, FIRST_STRIDE / max(farthest, 1e-9)))


def shell_posterior(
    setting: ShellSetting, image: Image, pose: Pose, rule: Rule = "whole"
) -> ShellPosterior:
    """The posterior of a frame.

    Parameters
    ----------
    setting : ShellSetting
    image : (H, W, 3) uint8 RGB
    pose : Pose
        Of the head: known, or a guess.
    rule : str
        One of `RULES`.
    """
    window = shell_window(setting, pose)
    inside = zone(window)
    raw = setting.classes.probabilities(sampled(window, image))
    fine = _planes(hamming(raw, SMOOTHING * DRAWN_MOUTH)) * inside
    wide = _planes(hamming(raw, PULL * DRAWN_MOUTH))
    outside = np.clip(1 - fine[1] - fine[2], 0, 1) * inside
    wide = wide - np.clip(1 - wide[1] - wide[2], 0, 1)
    pixels = int(inside.sum())
    side = max(SIDE, SIDE_OF_MOUTH * mouth_across(setting, pose)) * window.scale
    likelihood = FacetLikelihood(
        setting.renderer, setting.scene, setting.camera, window,
        ClassMaps(np.asarray(fine, np.float32)), pixels, pixels / side**2,
        np.asarray(outside, np.float32), setting.score, inside,
    )  # fmt: skip
    frame = PoseFrame(pose, setting.border.mean(axis=0))
    return ShellPosterior(
        setting,
        frame,
        likelihood,
        _prior(setting),
        Pull(wide * inside, slopes(wide) * inside),
        rule,
    )


def _prior(setting: ShellSetting) -> GaussianPrior | MixturePrior:
    """Over all 6 + P parameters (eq. 10)."""
    free = setting.pose_deviation
    deviation = np.r_[np.ones(6) if free is None else free, np.ones(setting.model.n_modes)]
    gaussian = GaussianPrior(np.zeros(len(deviation)), deviation)
    return gaussian if setting.seen is None else MixturePrior(gaussian, setting.seen, WIDTH)


def _planes(probable: FloatArray) -> FloatArray:
    """One map for each facet class of the shell: none, skin, lips, and what the opening shows."""
    of = dict(zip(CLASSES, probable, strict=True))
    lips = of["lips"] + IN_SHADE * of["dark"]
    shown = {"skin": of["skin"], "lips": lips, "interior": of["teeth"] + of["dark"]}
    skin = of["skin"]
    return np.stack([np.zeros_like(skin) if c is None else shown[c] for c in COLOUR_OF])
