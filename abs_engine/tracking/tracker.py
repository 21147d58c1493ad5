"""Frame after frame: an iterator of results, each started from the one before."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Scene
from abs_engine.face.head import MouthModel
from abs_engine.fit.head_frame import best_start
from abs_engine.optimise.base import Solution
from abs_engine.tracking.covered import (
    COVERED,
    OUTSIDE,
    MouthEvidence,
    UsualMouth,
    mouth_evidence,
)
from abs_engine.tracking.frame_work import FrameWork, frame_work, solve
from abs_engine.tracking.landmark_motion import HeadFrame
from abs_engine.tracking.mouth_look import MouthLook
from abs_engine.tracking.place import CalibrationFrame, shifted
from abs_engine.tracking.setting import BOTH, LANDMARKS, NO_FACE, FrameResult, TrackerSetting

FloatArray = NDArray[np.float64]
Image = NDArray[np.uint8]
HELD = "held to the landmarks"
"""Status of a frame whose colours led off the landmarks, twice: these alone are reported."""
MOST_OFF, ASTRAY = 1.75, 6.0
"""Standard deviations (RMS over the lips) that an accepted fit may lie off the landmarks, and from
which on these are no mouth's."""


def track(
    setting: TrackerSetting, frames: Iterable[HeadFrame]
) -> Iterator[tuple[Image, FrameResult]]:
    """Fit every frame.

    Parameters
    ----------
    setting : TrackerSetting
    frames : iterable of HeadFrame
        Their poses by landmarks or the head's rigid motion, or as given; None where the face was
        lost, or no pose was given.

    Yields
    ------
    image, FrameResult
        Each frame with what was found in it.
    """
    last: FloatArray | None = None
    for index, frame in enumerate(frames):
        image, pose = frame.image, frame.pose
        if pose is None:
            last = None
            yield image, replace(_lost(setting, index), status=setting.why_lost)
            continue
        hidden = _hidden(setting, frame, pose)
        if hidden:
            last = None
            there = shifted(pose, setting.calibration.shift, setting.model.pivot)
            yield image, replace(_lost(setting, index), pose=there, status=hidden, covered=True)
            continue
        result = _fit(setting, index, frame, pose, last)
        last = result.vector
        yield image, result


def usual_mouth(setting: TrackerSetting, frames: Iterable[CalibrationFrame]) -> UsualMouth | None:
    """What the mouth usually looks like, by the frames that the person was fitted on."""
    return UsualMouth.of([_evidence(setting, f.image, f.pose) for f in frames])


def _hidden(setting: TrackerSetting, frame: HeadFrame, pose: Pose) -> str:
    """Why the mouth cannot be seen; empty where it can."""
    if setting.look is not None and frame.face is not None:
        look = MouthLook.of(setting.classes, frame.image, frame.face.landmarks)
        if look is None:
            return OUTSIDE
        return COVERED if setting.look.hidden(look) else ""
    if setting.usual is None:
        return ""
    now = _evidence(setting, frame.image, pose)
    if now is None:
        return OUTSIDE
    return COVERED if setting.usual.covered(now) else ""


def _evidence(setting: TrackerSetting, image: Image, pose: Pose) -> MouthEvidence | None:
    there = shifted(pose, setting.calibration.shift, setting.model.pivot)
    person = setting.calibration.person
    return mouth_evidence(setting.classes, setting.model, setting.camera, image, there, person)


def _fit(
    setting: TrackerSetting, index: int, frame: HeadFrame, pose: Pose, last: FloatArray | None
) -> FrameResult:
    """The most probable pose and posture; once more from the landmarks where it lies off them."""
    model, work = setting.model, frame_work(setting, frame, pose, last)
    posterior, told = work.posterior, work.told
    if setting.evidence == LANDMARKS and told is not None:
        solution = solve(setting, work.without_colours, told)
        return _result(setting, index, work, solution)
    usual = np.hstack([np.zeros((len(model.prototypes), 6)), model.prototypes])
    starts = np.vstack([*(x for x in (last, told) if x is not None), usual])
    solution = solve(setting, posterior, best_start(posterior, starts))
    count, status = solution.n_evaluations + len(starts), solution.status
    both = setting.evidence == BOTH
    if both and told is not None and work.off(solution.x)[1] > MOST_OFF:
        again = solve(setting, posterior, told)
        count, solution, status = count + again.n_evaluations, again, again.status
        if work.off(again.x)[1] > MOST_OFF:
            solution, status = solve(setting, work.without_colours, told), HELD
            count += solution.n_evaluations
            if work.off(solution.x)[1] > ASTRAY:
                return replace(_lost(setting, index), status=setting.why_lost)
    return _result(setting, index, work, replace(solution, n_evaluations=count, status=status))


def _result(
    setting: TrackerSetting, index: int, work: FrameWork, solution: Solution
) -> FrameResult:
    x = solution.x
    value = work.posterior(x)
    likelihood = work.posterior.likelihood
    score = float(np.exp(-value.terms["likelihood"] / likelihood.observations))
    lips, width, aperture = lip_measures(setting.model, setting.scene, x[6:])
    told = work.told
    by_landmarks = float("nan")
    if told is not None:
        by_landmarks = lip_measures(setting.model, setting.scene, told[6:])[2]
    return FrameResult(
        index, True, x, work.posterior.frame.pose(x), lips, width, aperture, value.value, score,
        solution.n_evaluations, solution.status,
        landmark_distance=work.off(x)[0], landmark_aperture=by_landmarks,
    )  # fmt: skip


def lip_measures(
    model: MouthModel, scene: Scene, weights: FloatArray
) -> tuple[FloatArray, float, float]:
    """Lip contours (N, 3) in mm, head frame; mouth width and aperture in mm.

    The aperture is the height between the middles of the upper and lower inner lip, 0 when they
    touch; the width is the distance between the corners.
    """
    vertices = scene.vertices(weights)
    ring = model.rings
    lips = np.concatenate(
        [vertices[ring["outer"]], vertices[ring["upper"]], vertices[ring["lower"]]]
    )
    corners = vertices[ring["corners"]]
    return lips, float(np.linalg.norm(corners[1] - corners[0])), model.opening(vertices)


def _lost(setting: TrackerSetting, index: int) -> FrameResult:
    nothing = np.full(6 + setting.model.n_expression, np.nan)
    n = sum(len(setting.model.rings[k]) for k in ("outer", "upper", "lower"))
    nan = float("nan")
    return FrameResult(
        index, False, nothing, None, np.full((n, 3), nan), nan, nan, nan, nan, 0, NO_FACE
    )
