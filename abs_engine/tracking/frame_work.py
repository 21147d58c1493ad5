"""One frame as it is fitted: its posterior, its priors, and what its landmarks say of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from abs_engine.compare.prior import GaussianPrior, InformationPrior
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import PoseFrame, pose_spec
from abs_engine.fit.head_frame import (
    FramePosterior,
    Prior,
    class_maps,
    contact_prior,
    likelihood_of,
    mouth_window,
)
from abs_engine.optimise.base import Solution
from abs_engine.tracking.landmark_motion import HeadFrame
from abs_engine.tracking.mouth_place import mouth_place
from abs_engine.tracking.person import POSE_DEVIATION
from abs_engine.tracking.place import shifted
from abs_engine.tracking.setting import RENDERING, TrackerSetting

FloatArray = NDArray[np.float64]
STEP_DEVIATION = 0.8
"""How far a posture moves in 40 ms, in standard deviations of a mode: in speech by 0.3 (RMS of
authored and of tracked motion), but in one step of a hundred by 1.1."""


@dataclass(frozen=True, eq=False)
class FrameWork:
    """A frame's posterior, and what its landmarks say: where they put the mouth, (6 + P,)."""

    posterior: FramePosterior
    without_colours: FramePosterior
    told: FloatArray | None
    apart: Callable[[Pose, FloatArray], tuple[float, float]] | None

    def off(self, x: FloatArray) -> tuple[float, float]:
        """How far the lips lie off the landmarks (RMS), in mm and in standard deviations.

        NaN and 0 where there are none.
        """
        if self.apart is None:
            return float("nan"), 0.0
        return self.apart(self.posterior.frame.pose(x), x[6:])


def frame_work(
    setting: TrackerSetting, frame: HeadFrame, pose: Pose, last: FloatArray | None
) -> FrameWork:
    """What is minimised in a frame whose head is about a pose, after one with `last` (6 + P,)."""
    model, person, face = setting.model, setting.calibration.person, frame.face
    base = PoseFrame(shifted(pose, setting.calibration.shift, model.pivot), model.pivot)
    window = mouth_window(model, base.base, setting.camera, person)
    told = place = None
    priors = beside_colours = without_colours = _priors(setting, last, thick=face is not None)
    if face is not None:
        told = np.r_[np.zeros(6), face.fit.posture[: model.n_expression]]
        if setting.evidence != RENDERING:
            place = mouth_place(model, base, setting.camera, window, person, told)
        evidence = face.fit.evidence(model.n_expression)
        beside_colours = (*priors, _less_sure(evidence, setting.classes.outdoing))
        without_colours = (*priors, evidence)
    maps = class_maps(setting.classes, model.colour_classes, window, frame.image, place)
    drawn = setting.renderer, setting.scene, setting.camera
    likelihood = likelihood_of(*drawn, window, maps, setting.classes.weight)
    both = setting.evidence != RENDERING
    alone = FramePosterior(replace(likelihood, observations=0.0), base, without_colours)
    posterior = FramePosterior(likelihood, base, beside_colours if both else priors)
    apart = None
    if setting.lips is not None and face is not None:
        apart = partial(setting.lips.apart, face.landmarks)
    return FrameWork(posterior, alone, told, apart)


def _less_sure(told: InformationPrior, factor: float) -> InformationPrior:
    """What landmarks say, their noise in the posture this many times as large."""
    scale = np.r_[np.ones(6), np.full(len(told.mean) - 6, 1 / factor)]
    return replace(told, information=told.information * np.outer(scale, scale))


def solve(setting: TrackerSetting, posterior: FramePosterior, start: FloatArray) -> Solution:
    """Minimise over all parameters (6 + P), or with a held pose over the last P."""
    spec = pose_spec(setting.model.n_expression)
    if not setting.pose_held:
        return setting.solver.minimise(posterior, start, spec)
    pose = np.zeros(6)
    found = setting.solver.minimise(
        lambda x: posterior(np.r_[pose, x]), start[6:], spec.only(np.arange(6, len(spec)))
    )
    return replace(found, x=np.r_[pose, found.x])


def _priors(
    setting: TrackerSetting, last: FloatArray | None, thick: bool = False
) -> tuple[Prior, ...]:
    p = setting.model.n_expression
    likely = GaussianPrior(np.zeros(6 + p), np.r_[POSE_DEVIATION, np.ones(p)])
    contact = contact_prior(setting.model, setting.calibration.person, thick)
    if last is None:
        return likely, contact
    step = STEP_DEVIATION * np.sqrt(25.0 / setting.rate)
    near = GaussianPrior(last, np.r_[POSE_DEVIATION, np.full(p, step)])
    return likely, contact, near
