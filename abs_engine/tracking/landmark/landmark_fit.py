"""Head pose and posture by the landmarks alone: Gauss-Newton on their places.

Landmarks are where fits start, and one soft piece of evidence: what they say of a frame is kept as
a Gaussian over its pose and posture (`FrameLandmarks`), which costs nothing to evaluate.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from abs_engine.compare.prior import InformationPrior
from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import FACING, Pose, rotations
from abs_engine.core.pose import at_base
from abs_engine.core.settings import GENERAL
from abs_engine.core.threads import one_thread
from abs_engine.tracking.detection.landmarks import (
    COUNT,
    EYES,
    INNER_RING,
    LIPS,
    OUTER_RING,
    Landmarks,
    SeenRays,
)
from abs_engine.tracking.detection.mouth_search import shifted
from abs_engine.tracking.landmark.head_equations import Equations, reach_of, without_rest
from abs_engine.tracking.landmark.landmark_jacobian import weighed_residuals
from abs_engine.tracking.landmark.landmark_shape import LandmarkShape
from abs_engine.tracking.landmark.lip_openings import LipOpenings
from abs_engine.tracking.settings.head import HEAD_POSE
from abs_engine.tracking.settings.landmarks import LANDMARK_EVIDENCE

_DAMPING = 1e-6


@dataclass(frozen=True, eq=False)
class HeldPose:
    """A pose that other evidence tells.

    Parameters
    ----------
    information : (6, 6) float64
        About rotation (camera axes, about the pivot; rad) and the pivot's place (mm).
    """

    pose: Pose
    information: FloatArray


@dataclass(frozen=True, eq=False)
class FrameLandmarks:
    """Evidence of the landmarks of one frame.

    Parameters
    ----------
    pose : Pose
        Head to camera.
    posture : (M,) float64
        Most probable weights, with their prior.
    information : (6 + M, 6 + M) float64
        Of the landmarks alone, about rotation (camera axes, about the pivot; rad), the pivot's
        place (mm) and posture: the inverse of their covariance.
    gradient : (6 + M,) float64
        Of the landmarks' -log likelihood there (the priors' pull balances it).
    misfit : float
        RMS distance of the landmarks from where the fit puts them, in their standard deviations.
    held : HeldPose or None
        Where other evidence held the pose.
    """

    pose: Pose
    posture: FloatArray
    information: FloatArray
    gradient: FloatArray
    misfit: float
    held: HeldPose | None = None

    def sound(self, shape: LandmarkShape) -> bool:
        """Whether the landmarks are a face's that lies before the camera."""
        near = float(self.pose.apply(shape.pivot)[2]) < GENERAL.nearest
        return bool(
            np.isfinite(self.misfit) and self.misfit < LANDMARK_EVIDENCE.most_misfit and not near
        )

    def evidence(self, modes: int) -> InformationPrior:
        """Evidence of landmarks alone on the pose (about `pose`) and the first `modes` of posture.

        The rest of the posture is integrated out, with its prior. Computed once.
        """
        if modes not in self._evidence:
            self._evidence[modes] = self._without(modes)
        return self._evidence[modes]

    @cached_property
    def _evidence(self) -> dict[int, InformationPrior]:
        return {}

    def _without(self, modes: int) -> InformationPrior:
        """The evidence on the first `modes`, the others integrated out."""
        kept = 6 + modes
        pull = np.r_[self.gradient[:kept], self.gradient[kept:] + self.posture[modes:]]
        information, gradient = without_rest(Equations(self.information, pull), kept)
        held = information + _DAMPING * np.diag(np.diag(information)) + 1e-9 * np.eye(kept)
        start = at_base(self.posture[:modes])
        return InformationPrior(start - np.linalg.solve(held, gradient), information)


_TOGETHER = np.full(COUNT, LANDMARK_EVIDENCE.others_together)
_TOGETHER[INNER_RING], _TOGETHER[OUTER_RING] = (
    LANDMARK_EVIDENCE.inner_together,
    LANDMARK_EVIDENCE.outer_together,
)
_STRAY = np.full(COUNT, LANDMARK_EVIDENCE.stray)
_STRAY[LIPS] = LANDMARK_EVIDENCE.stray_lips
_FLAT = np.zeros(COUNT, bool)
_FLAT[LIPS] = True  # depths of lips say nothing of their opening


def fit_frame(
    shape: LandmarkShape,
    landmarks: Landmarks,
    camera: Camera,
    start: FrameLandmarks | None = None,
    held: HeldPose | None = None,
    trust: FloatArray | None = None,
    settled: float = HEAD_POSE.frame_settled,
) -> FrameLandmarks:
    """Pose and posture of a known person by the landmarks of a frame.

    Parameters
    ----------
    shape : LandmarkShape
        Of a person: without identity modes.
    start : FrameLandmarks, optional
        Where to begin, as the frame before; by default the face is taken to look ahead.
    held : HeldPose, optional
        What else tells of the pose, these landmarks among it: the pose stays there. It is part
        of the result's information.
    trust : (468,) float64, optional
        Weight of each landmark, 0 to 1; by default all are trusted.
    settled : float, rad and standard deviations
        A step by less ends it.
    """
    with one_thread():
        seen = SeenRays.of(landmarks, camera, trust)
        openings = LipOpenings.of(shape, seen)
        pose = looking_ahead(shape, seen) if start is None else start.pose
        posture = np.zeros(len(shape.posture)) if start is None else start.posture
        if held is not None:
            pose = held.pose
        for _ in range(LANDMARK_EVIDENCE.steps):
            found, misfit = _normal(shape, seen, openings, pose, posture)
            step = _step(found, posture, held is not None)
            pose, posture = shifted(pose, step, shape.pivot), posture + step[6:]
            if np.abs(np.r_[step[:3], step[6:]]).max() < settled:
                break
        else:
            found, misfit = _normal(shape, seen, openings, pose, posture)
            step = np.zeros_like(step)
    information, gradient = found.after(step)  # where the last step, which is short, leads
    if held is not None:
        information[:6, :6] += held.information
    return FrameLandmarks(pose, posture, information, gradient, misfit, held)


def _step(found: Equations, posture: FloatArray, held: bool) -> FloatArray:
    """Newton's step (6 + M,); the prior of a posture is a unit Gaussian, a pose has none."""
    own = found.information + np.diag(np.r_[np.zeros(6), np.ones(len(posture))])
    pull = found.gradient + np.r_[np.zeros(6), posture]
    own, free = own + _DAMPING * np.diag(np.diag(own)), slice(6 if held else 0, None)
    step = np.zeros(len(pull))
    step[free] = -np.linalg.solve(own[free, free], pull[free])
    return step


def sound_fit(
    shape: LandmarkShape,
    landmarks: Landmarks,
    camera: Camera,
    last: FrameLandmarks | None,
    settled: float = HEAD_POSE.frame_settled,
) -> FrameLandmarks | None:
    """`fit_frame` from the frame before, or afresh if that leads astray; None where both do."""
    for start in [None] if last is None else [last, None]:
        try:
            found = fit_frame(shape, landmarks, camera, start, settled=settled)
        except np.linalg.LinAlgError:
            continue
        if found.sound(shape):
            return found
    return None


def looking_ahead(shape: LandmarkShape, seen: SeenRays) -> Pose:
    """A head that looks ahead, as large as the eyes are apart, or the face is high."""
    right, left = (seen.rays[pair].mean(axis=0) for pair in EYES)
    apart = np.linalg.norm(shape.mean[EYES[0]].mean(axis=0) - shape.mean[EYES[1]].mean(axis=0))
    depth = min(
        reach_of(shape, seen), float(apart) / max(float(np.linalg.norm(left - right)), 1e-9)
    )
    (along, _), roll = seen.axes, np.zeros((1, 3))
    roll[0, 2] = np.arctan2(along[1], along[0])
    rotation = rotations(roll)[0] @ FACING
    middle = np.r_[seen.rays.mean(axis=0), 1.0] * depth
    return Pose(rotation, middle - rotation @ shape.mean.mean(axis=0))


def _normal(
    shape: LandmarkShape, seen: SeenRays, openings: LipOpenings, pose: Pose, posture: FloatArray
) -> tuple[Equations, float]:
    """Equations (6 + M) of landmarks' residuals, in standard deviations, and their misfit.

    Each counts less where it is hidden, or far off (Cauchy). What the distances between the inner
    lips say is added.
    """
    flat, residual = np.empty((6 + len(posture), 3 * COUNT)), np.empty((COUNT, 3))
    misfit = weighed_residuals(
        shape.mean, shape.posture, shape.normals, posture,
        np.column_stack([pose.rotation, pose.translation]), pose.apply(shape.pivot), seen.rays,
        seen.depth, seen.axes, seen.trust, shape.bias, shape.deviation, _TOGETHER, _STRAY, _FLAT,
        LANDMARK_EVIDENCE.hidden, LANDMARK_EVIDENCE.guessed, residual, flat,
    )  # fmt: skip
    information, gradient = flat @ flat.T, flat @ residual.ravel()
    said = openings.equations(pose, posture)
    information[6:, 6:] += said.information
    gradient[6:] += said.gradient
    return Equations(information, gradient), float(misfit)
