"""Head pose, identity and posture by the landmarks alone: Gauss-Newton on their places.

Landmarks are where fits start, and one soft piece of evidence: what they say of a frame is kept as
a Gaussian over its pose and posture (`FrameLandmarks`), which costs nothing to evaluate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController

from abs_engine.camera import Camera
from abs_engine.compare.prior import InformationPrior
from abs_engine.geometry import FACING, Pose, rotations
from abs_engine.track.landmark_shape import LandmarkShape, SeenRays
from abs_engine.track.landmarks import COUNT, EYES, LIPS, Landmarks

FloatArray = NDArray[np.float64]

LIPS_TOGETHER, OTHERS_TOGETHER = 4.0, 100.0
"""Landmarks that err together: so many count as one. Of what the network is off by within a person,
the 936 numbers of all landmarks move like 9 independent ones. Of the lips, most of what they have
in common moves with the head's pose; 4 rather than 12 were chosen on p01 to p06 of the strangers'
clips, where apertures by landmarks then correlate by 0.79 to 0.92 with another network's (0.62)."""
IDENTITY_TOGETHER = 6.0
"""The same where the identity is fitted, to which what is common to many landmarks belongs."""
MOST_MISFIT, NEAREST = 6.0, 50.0
"""Misfit from which on landmarks are no face's, and least distance from the camera, mm. Of faces it
is about 1 to 2; of points strewn over a picture, 25."""
_STRAY = 3.0  # standard deviations, from where on a landmark counts less and less
_HIDDEN = 0.15  # cosine between surface and line of sight, below which a landmark is guessed
_GUESSED = 0.05  # weight of such a landmark
_STEPS, _SETTLED = 12, 1e-3  # of Gauss-Newton; radians or standard deviations
_DAMPING = 1e-6


@dataclass(frozen=True, eq=False)
class FrameLandmarks:
    """What the landmarks of one frame say.

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
    """

    pose: Pose
    posture: FloatArray
    information: FloatArray
    gradient: FloatArray
    misfit: float

    def sound(self, shape: LandmarkShape) -> bool:
        """Whether the landmarks are a face's that lies before the camera."""
        near = float(self.pose.apply(shape.pivot)[2]) < NEAREST
        return bool(np.isfinite(self.misfit) and self.misfit < MOST_MISFIT and not near)

    def evidence(self, modes: int) -> InformationPrior:
        """What the landmarks alone say of pose (about `pose`) and the first `modes` of posture.

        The rest of the posture is integrated out, with its prior.

        Returns
        -------
        InformationPrior
            Over (6 + modes).
        """
        kept, rest = np.arange(6 + modes), np.arange(6 + modes, len(self.gradient))
        own = self.information[np.ix_(rest, rest)] + np.eye(len(rest))
        gain = np.linalg.solve(own, self.information[np.ix_(rest, kept)])
        information = self.information[np.ix_(kept, kept)]
        information = information - self.information[np.ix_(kept, rest)] @ gain
        pull = self.gradient[rest] + self.posture[modes:]
        gradient = self.gradient[kept] - pull @ gain
        held = information + _DAMPING * np.diag(np.diag(information)) + 1e-9 * np.eye(len(kept))
        start = np.r_[np.zeros(6), self.posture[:modes]]
        return InformationPrior(start - np.linalg.solve(held, gradient), information)


@dataclass(frozen=True, eq=False)
class PersonLandmarks:
    """Who somebody is, by the landmarks of several frames.

    Parameters
    ----------
    identity : (K,) float64
        In standard deviations.
    covariance : (K, K) float64
    frames : tuple of FrameLandmarks
    """

    identity: FloatArray
    covariance: FloatArray
    frames: tuple[FrameLandmarks, ...]


@dataclass(frozen=True, eq=False)
class _Normal:
    """Normal equations of a frame: information and gradient over (6 + K + M), and its value."""

    information: FloatArray
    gradient: FloatArray
    misfit: float


_TOGETHER = np.full(COUNT, OTHERS_TOGETHER)
_TOGETHER[LIPS] = LIPS_TOGETHER


def fit_frame(
    shape: LandmarkShape, landmarks: Landmarks, camera: Camera, start: FrameLandmarks | None = None
) -> FrameLandmarks:
    """Pose and posture of a known person by the landmarks of a frame.

    Parameters
    ----------
    shape : LandmarkShape
        Of a person: without identity modes.
    landmarks : Landmarks
    camera : Camera
    start : FrameLandmarks, optional
        The frame before; by default the face is taken to look ahead.
    """
    return fit_person(shape, [landmarks], camera, None if start is None else [start]).frames[0]


def fit_person(
    shape: LandmarkShape,
    landmarks: Sequence[Landmarks],
    camera: Camera,
    starts: Sequence[FrameLandmarks] | None = None,
) -> PersonLandmarks:
    """One person, and a pose and posture for each frame, most probable by the landmarks.

    The network errs alike in all frames of a person: all together say as much of the identity as
    one of them.

    Parameters
    ----------
    shape : LandmarkShape
    landmarks : sequence of Landmarks, N
    camera : Camera
    starts : sequence of FrameLandmarks, optional
        Where to begin; by default the faces look ahead.
    """
    with _threads().limit(limits=1):
        return _fitted(shape, [SeenRays.of(one, camera) for one in landmarks], starts)


def sound_fit(
    shape: LandmarkShape, landmarks: Landmarks, camera: Camera, last: FrameLandmarks | None
) -> FrameLandmarks | None:
    """`fit_frame` from the frame before, or afresh if that leads astray; None where both do."""
    for start in [None] if last is None else [last, None]:
        try:
            found = fit_frame(shape, landmarks, camera, start)
        except np.linalg.LinAlgError:
            continue
        if found.sound(shape):
            return found
    return None


@cache
def _threads() -> ThreadpoolController:
    """Of BLAS: on matrices as small as these its threads only wait for each other."""
    return ThreadpoolController()


def _fitted(
    shape: LandmarkShape, seen: Sequence[SeenRays], starts: Sequence[FrameLandmarks] | None
) -> PersonLandmarks:
    k, m, n = len(shape.identity), len(shape.posture), len(seen)
    poses = [s.pose for s in starts] if starts else [_ahead(shape, s) for s in seen]
    postures = np.array([s.posture for s in starts]) if starts else np.zeros((n, m))
    identity = np.zeros(k)
    for _ in range(_STEPS):
        equations = [
            _normal(shape, s, p, identity, x) for s, p, x in zip(seen, poses, postures, strict=True)
        ]
        step, frames = _solved(equations, identity, postures, k)
        identity = identity + step
        poses = [_turned(shape, p, f[:6]) for p, f in zip(poses, frames, strict=True)]
        postures = postures + frames[:, 6:]
        moved = np.abs(np.r_[step, frames[:, :3].ravel(), frames[:, 6:].ravel()])
        if moved.max(initial=0.0) < _SETTLED:
            break
    final = [
        _normal(shape, s, p, identity, x) for s, p, x in zip(seen, poses, postures, strict=True)
    ]
    held = np.r_[0:6, 6 + k : 6 + k + m]
    found = tuple(
        FrameLandmarks(p, x, e.information[np.ix_(held, held)], e.gradient[held], e.misfit)
        for p, x, e in zip(poses, postures, final, strict=True)
    )
    covariance = np.zeros((0, 0))
    if k:
        covariance = np.asarray(np.linalg.inv(_marginal(final, k)[0]), np.float64)
    return PersonLandmarks(identity, covariance, found)


def _ahead(shape: LandmarkShape, seen: SeenRays) -> Pose:
    """A head that looks ahead, as large as the eyes are apart, or the face is high."""
    right, left = (seen.rays[pair].mean(axis=0) for pair in EYES)
    apart = np.linalg.norm(shape.mean[EYES[0]].mean(axis=0) - shape.mean[EYES[1]].mean(axis=0))
    height = float(np.ptp(shape.mean[:, 1])) / max(float(np.ptp(seen.rays @ seen.axes[1])), 1e-9)
    depth = min(height, float(apart) / max(float(np.linalg.norm(left - right)), 1e-9))
    (along, _), roll = seen.axes, np.zeros((1, 3))
    roll[0, 2] = np.arctan2(along[1], along[0])
    rotation = rotations(roll)[0] @ FACING
    middle = np.r_[seen.rays.mean(axis=0), 1.0] * depth
    return Pose(rotation, middle - rotation @ shape.mean.mean(axis=0))


def _turned(shape: LandmarkShape, pose: Pose, step: FloatArray) -> Pose:
    turned = rotations(step[None, :3])[0] @ pose.rotation
    return Pose(turned, pose.apply(shape.pivot) + step[3:] - turned @ shape.pivot)


def _normal(
    shape: LandmarkShape, seen: SeenRays, pose: Pose, identity: FloatArray, posture: FloatArray
) -> _Normal:
    """Linearise the landmarks' residuals, mm at the head, in their standard deviations."""
    modes = np.concatenate([shape.identity, shape.posture])
    weights = np.concatenate([identity, posture])
    points = shape.mean + np.tensordot(weights, modes, 1)
    there = pose.apply(points)
    z, depth = there[:, 2], float(pose.apply(shape.pivot)[2])
    ray = there[:, :2] / z[:, None]
    off = (ray - seen.rays) * depth @ seen.axes.T + shape.bias
    sunk = seen.depth * depth - z
    residual = np.column_stack([off, sunk.mean() - sunk]) / shape.deviation
    motion = _motions(shape, pose, there, modes)  # (6 + K + M, 468, 3), camera frame
    across = (motion[..., :2] - ray * motion[..., 2:]) * (depth / z)[:, None] @ seen.axes.T
    deep = motion[..., 2] - motion[..., 2].mean(axis=1, keepdims=True)
    slope = np.concatenate([across, deep[..., None]], axis=-1) / shape.deviation
    together = _TOGETHER if len(shape.identity) == 0 else IDENTITY_TOGETHER
    trust = _trust(shape, pose, there, residual) / together
    flat = (slope * trust[:, None]).reshape(len(slope), -1)
    information = flat @ slope.reshape(len(slope), -1).T
    misfit = float(np.sqrt((residual[:, :2] ** 2).mean()))
    return _Normal(information, flat @ residual.ravel(), misfit)


def _motions(shape: LandmarkShape, pose: Pose, there: FloatArray, modes: FloatArray) -> FloatArray:
    arm = there - pose.apply(shape.pivot)
    turns = np.stack([np.cross(axis, arm) for axis in np.eye(3)])
    moves = np.broadcast_to(np.eye(3)[:, None], (3, *there.shape))
    return np.concatenate([turns, moves, modes @ pose.rotation.T])


def _trust(shape: LandmarkShape, pose: Pose, there: FloatArray, residual: FloatArray) -> FloatArray:
    """Weight (468,) of each landmark: less where it is hidden, or far off (Cauchy)."""
    sight = there / np.linalg.norm(there, axis=1, keepdims=True)
    facing = -(shape.normals @ pose.rotation.T * sight).sum(axis=1)
    shown = np.clip((facing - _HIDDEN) / (1 - _HIDDEN), _GUESSED, 1.0)
    return np.asarray(shown / (1 + (residual[:, :2] ** 2).sum(axis=1) / _STRAY**2))


def _marginal(
    equations: Sequence[_Normal], k: int
) -> tuple[FloatArray, list[tuple[FloatArray, FloatArray]]]:
    """Information (K, K) about the identity with the frames integrated out, prior included.

    And of each frame the inverse of its own part, and that times the part shared with identity.
    """
    information, parts = np.eye(k), []
    for e in equations:
        own, shared = _own(e, k)
        inverse = np.asarray(np.linalg.inv(own), np.float64)
        gain = inverse @ shared
        parts.append((inverse, gain))
        information += (e.information[6 : 6 + k, 6 : 6 + k] - shared.T @ gain) / len(equations)
    return information, parts


def _own(e: _Normal, k: int) -> tuple[FloatArray, FloatArray]:
    """A frame's information about its own pose and posture, with their prior, and what it shares.

    The prior of a posture is a Gaussian of unit variance; a pose has none.
    """
    held = np.r_[0:6, 6 + k : len(e.gradient)]
    own = e.information[np.ix_(held, held)] + np.diag(np.r_[np.zeros(6), np.ones(len(held) - 6)])
    return own + _DAMPING * np.diag(np.diag(own)), e.information[held, 6 : 6 + k]


def _solved(
    equations: Sequence[_Normal], identity: FloatArray, postures: FloatArray, k: int
) -> tuple[FloatArray, FloatArray]:
    """The step of the identity (K,), and of each frame's pose and posture (N, 6 + M)."""
    information, parts = _marginal(equations, k)
    gradient, frames = identity.copy(), []
    for e, (_, gain), posture in zip(equations, parts, postures, strict=True):
        own = np.r_[e.gradient[:6], e.gradient[6 + k :] + posture]
        gradient += (e.gradient[6 : 6 + k] - gain.T @ own) / len(equations)
        frames.append(own)
    step = -np.asarray(np.linalg.solve(information, gradient), np.float64)
    each = [
        -inverse @ own - gain @ step for (inverse, gain), own in zip(parts, frames, strict=True)
    ]
    return step, np.array(each)
