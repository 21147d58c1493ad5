"""Frame after frame: an iterator of results, each started from the one before."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from abs_engine.appearance.colour import ColourClasses
from abs_engine.camera import Camera
from abs_engine.compare.prior import GaussianPrior
from abs_engine.geometry import Pose
from abs_engine.optimise.base import Solution
from abs_engine.optimise.simplex import Simplex
from abs_engine.scene import Renderer, Scene
from abs_engine.track.covered import (
    COVERED,
    OUTSIDE,
    MouthEvidence,
    UsualMouth,
    mouth_evidence,
)
from abs_engine.track.fit import (
    FramePosterior,
    Prior,
    best_start,
    class_maps,
    contact_prior,
    likelihood_of,
    mouth_window,
)
from abs_engine.track.landmark_motion import HeadFrame
from abs_engine.track.lip_landmarks import LipLandmarks
from abs_engine.track.model import MouthModel
from abs_engine.track.mouth_look import MouthLook, UsualLook
from abs_engine.track.mouth_place import mouth_place
from abs_engine.track.person import POSE_DEVIATION, Calibration
from abs_engine.track.place import CalibrationFrame, shifted
from abs_engine.track.pose import PoseFrame, pose_spec

FloatArray = NDArray[np.float64]
Image = NDArray[np.uint8]
NO_FACE, NO_POSE = "face not found", "no pose given"
HELD = "held to the landmarks"
"""Status of a frame whose colours led off the landmarks, twice: these alone are reported."""
EVIDENCE = ("both", "rendering", "landmarks")
MOST_OFF = 1.75
"""Standard deviations (RMS over the lips) that an accepted fit may lie off the landmarks."""
INNER = 12  # the inner contour's first among the 20 reported points
FRAME_SOLVER = Simplex(tolerance=0.03, limit=400)
STEP_DEVIATION = 0.8
"""How far a posture moves in 40 ms, in standard deviations of a mode: in speech by 0.3 (RMS of
authored and of tracked motion), but in one step of a hundred by 1.1."""


@dataclass(frozen=True, eq=False)
class FrameResult:
    """What was found in one frame.

    Parameters
    ----------
    index : int
    found : bool
        Whether the lips were followed; if not, the numbers are NaN.
    vector : (6 + P,) float64
        Pose correction about the rigid motion's pose, then expression.
    pose : Pose or None
        Head to camera.
    lips : (N, 3) float64, mm, head frame
        Outer contour, upper and lower inner contour.
    width, aperture : float, mm
        Between the mouth's corners; between the inner lips at their middle, 0 when they touch.
    value : float
        -log posterior, up to a constant.
    score : float
        Mean probability of the drawn classes, 0 to 1: eq. 9 over the compared pixels.
    evaluations : int
    status : str
        How the solver ended; or why nothing was found.
    covered : bool
        Whether the face is there, but its mouth is hidden or outside of the picture; then nothing
        is found but the head's pose.
    landmark_distance : float, mm
        RMS distance, across the line of sight, of the lips from where the landmark network sees
        them; NaN where it was not asked.
    landmark_aperture : float, mm
        What `aperture` would be by the landmarks alone.
    """

    index: int
    found: bool
    vector: FloatArray
    pose: Pose | None
    lips: FloatArray
    width: float
    aperture: float
    value: float
    score: float
    evaluations: int
    status: str
    covered: bool = False
    landmark_distance: float = float("nan")
    landmark_aperture: float = float("nan")


@dataclass(frozen=True, eq=False)
class TrackerSetting:
    """What stays the same over a clip.

    Parameters
    ----------
    model : MouthModel
    scene : Scene
        The model's scene with the person held.
    calibration : Calibration
    camera : Camera
    renderer : Renderer
    rate : float
        Frames per second.
    solver : Simplex
    times : tuple of float
        When each frame is shown, seconds; empty where only the rate is known.
    usual : UsualMouth, optional
        What the clip's mouth looks like; without it no frame counts as covered.
    poses_given : bool
        Whether the poses were measured elsewhere. A known head's are then held.
    look : UsualLook, optional
        The same by landmarks, which then count in its place.
    lips : LipLandmarks, optional
        Where the landmark network sees the lips of this head; with it the network is asked.
    evidence : str
        What counts: "both", or "rendering" or "landmarks" alone, to tell what each adds.
    """

    model: MouthModel
    scene: Scene
    calibration: Calibration
    camera: Camera
    renderer: Renderer
    rate: float
    solver: Simplex = FRAME_SOLVER
    times: tuple[float, ...] = ()
    usual: UsualMouth | None = None
    poses_given: bool = False
    look: UsualLook | None = None
    lips: LipLandmarks | None = None
    evidence: str = EVIDENCE[0]

    @property
    def pose_held(self) -> bool:
        """Whether poses are taken as they are, and only the posture is fitted.

        Those of another head than the person's own refer to an origin that is not quite its own:
        they are corrected as poses by rigid motion are.
        """
        return self.poses_given and self.model.known

    @property
    def why_lost(self) -> str:
        """What the status of a frame without a pose says."""
        return NO_POSE if self.poses_given else NO_FACE

    @property
    def classes(self) -> ColourClasses:
        """The clip's colour classes."""
        return self.calibration.classes


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
    model, work = setting.model, _frame_work(setting, frame, pose, last)
    posterior, told = work.posterior, work.told
    starts = np.hstack([np.zeros((len(model.prototypes), 6)), model.prototypes])
    if setting.evidence == EVIDENCE[2] and told is not None:
        solution = _solve(setting, work.without_colours, told)
        return _result(setting, index, work, solution)
    known = [x for x in (last, told) if x is not None]
    starts = np.vstack([*known, starts])
    solution = _solve(setting, posterior, best_start(posterior, starts))
    count, status = solution.n_evaluations + len(starts), solution.status
    both = setting.evidence == EVIDENCE[0]
    if both and told is not None and work.off(solution.x)[1] > MOST_OFF:
        again = _solve(setting, posterior, told)
        count, solution, status = count + again.n_evaluations, again, again.status
        if work.off(again.x)[1] > MOST_OFF:
            solution, status = _solve(setting, work.without_colours, told), HELD
            count += solution.n_evaluations
    return _result(setting, index, work, replace(solution, n_evaluations=count, status=status))


def _result(
    setting: TrackerSetting, index: int, work: _FrameWork, solution: Solution
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


@dataclass(frozen=True, eq=False)
class _FrameWork:
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


def _frame_work(
    setting: TrackerSetting, frame: HeadFrame, pose: Pose, last: FloatArray | None
) -> _FrameWork:
    model, person, face = setting.model, setting.calibration.person, frame.face
    base = PoseFrame(shifted(pose, setting.calibration.shift, model.pivot), model.pivot)
    window = mouth_window(model, base.base, setting.camera, person)
    told = place = None
    priors = with_landmarks = _priors(setting, last, thick=face is not None)
    if face is not None:
        told = np.r_[np.zeros(6), face.fit.posture[: model.n_expression]]
        if setting.evidence != EVIDENCE[1]:
            place = mouth_place(model, base, setting.camera, window, person, told)
        with_landmarks = (*priors, face.fit.evidence(model.n_expression))
    maps = class_maps(setting.classes, model.colour_classes, window, frame.image, place)
    drawn = setting.renderer, setting.scene, setting.camera
    likelihood = likelihood_of(*drawn, window, maps, setting.classes.weight)
    both = setting.evidence != EVIDENCE[1]
    alone = FramePosterior(replace(likelihood, observations=0.0), base, with_landmarks)
    posterior = FramePosterior(likelihood, base, with_landmarks if both else priors)
    apart = None
    if setting.lips is not None and face is not None:
        apart = partial(setting.lips.apart, face.landmarks)
    return _FrameWork(posterior, alone, told, apart)


def _solve(setting: TrackerSetting, posterior: FramePosterior, start: FloatArray) -> Solution:
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
    return lips, float(np.linalg.norm(corners[1] - corners[0])), _aperture(model, vertices)


def _aperture(model: MouthModel, vertices: FloatArray) -> float:
    points = vertices[model.rings["points"]]
    return float(max(0.0, points[INNER + 2, 1] - points[INNER + 6, 1]))


def _lost(setting: TrackerSetting, index: int) -> FrameResult:
    nothing = np.full(6 + setting.model.n_expression, np.nan)
    n = sum(len(setting.model.rings[k]) for k in ("outer", "upper", "lower"))
    nan = float("nan")
    return FrameResult(
        index, False, nothing, None, np.full((n, 3), nan), nan, nan, nan, nan, 0, NO_FACE
    )
