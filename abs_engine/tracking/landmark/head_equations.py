"""Linearised equations of landmarks and pupils: for pose, identity and posture.

The landmarks' errors are those of `LandmarkNoise`: the error that all frames of a person share is
estimated with the person, and the error that a frame's landmarks share is integrated out.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import pose_moves
from abs_engine.tracking.detection.landmarks import SeenRays
from abs_engine.tracking.landmark.landmark_jacobian import weighed_motion
from abs_engine.tracking.landmark.landmark_noise import LandmarkNoise
from abs_engine.tracking.landmark.landmark_shape import LandmarkShape, in_view
from abs_engine.tracking.settings.head import HEAD_POSE
from abs_engine.tracking.settings.landmarks import LANDMARK_EVIDENCE


class Equations(NamedTuple):
    """Information (D, D) and gradient (D,) of a -log likelihood."""

    information: FloatArray
    gradient: FloatArray

    def plus(self, other: Equations) -> Equations:
        """Sum of both."""
        return Equations(self.information + other.information, self.gradient + other.gradient)

    def after(self, step: FloatArray) -> Equations:
        """The equations after a step (D,), as far as they are linear."""
        return Equations(self.information, self.gradient + self.information @ step)

    def step(self) -> FloatArray:
        """Gauss-Newton's step (D,)."""
        return -np.asarray(np.linalg.solve(self.information, self.gradient), np.float64)

    def of_pose(self) -> FloatArray:
        """Information (6, 6) of the first six, a pose, whatever the others are."""
        pose, rest = slice(0, 6), slice(6, None)
        between = self.information[pose, rest]
        gain = np.linalg.solve(self.information[rest, rest], between.T)
        return np.asarray(self.information[pose, pose] - between @ gain)


class HeadGuess(NamedTuple):
    """Assumed pose of a frame's head, and its identity.

    Parameters
    ----------
    identity : (K,) float64
    error : (Q,) float64
        The network's error of this person, by the factors of `LandmarkNoise.between`.
    posture : (M,) float64
    """

    pose: Pose
    identity: FloatArray
    error: FloatArray
    posture: FloatArray


def landmark_equations(
    shape: LandmarkShape, noise: LandmarkNoise, seen: SeenRays, guess: HeadGuess, alike: float = 1.0
) -> Equations:
    """Equations of pose (6), identity (K), posture (M) and the person's error (Q), in this order.

    So many landmarks as are `alike` count as one.
    """
    modes = shape.modes
    points = shape.mean + np.tensordot(np.r_[guess.identity, guess.posture], modes, 1)
    there = guess.pose.apply(points)
    z, reach = there[:, 2], reach_of(shape, seen)
    ray = there[:, :2] / z[:, None]
    deep = seen.depth * float(z.mean()) - z
    off = np.column_stack([(seen.rays - ray) * reach @ seen.axes.T, deep - deep.mean()])
    off = off - noise.bias - np.tensordot(guess.error, noise.between, 1)
    root = np.sqrt(_weights(shape, noise, guess.pose, there, off))
    moves, known = 6 + len(modes), 6 + len(modes) + len(noise.between)
    flat = np.empty((known + len(noise.within), off.size))
    weighed_motion(
        there, guess.pose.apply(shape.pivot), modes, guess.pose.rotation, reach / z, seen.axes,
        seen.depth, root, flat[:moves],
    )  # fmt: skip
    np.multiply(noise.between, root, out=flat[moves:known].reshape(noise.between.shape))
    np.multiply(noise.within, root, out=flat[known:].reshape(noise.within.shape))
    # a matrix by its own transpose: BLAS makes half of it
    told = Equations(flat @ flat.T, -(flat @ (root * off).ravel()))
    information, gradient = without_rest(told, known)
    return Equations(information / alike, gradient / alike)


def reach_of(shape: LandmarkShape, seen: SeenRays) -> float:
    """Distance of a face that is as high as the average one, mm.

    The network's errors are a share of the face that it sees. Measured at the fitted head they
    would shrink with it, and a smaller head would always be more probable.
    """
    return float(np.ptp(shape.mean[:, 1])) / max(float(np.ptp(seen.rays @ seen.axes[1])), 1e-9)


def _weights(
    shape: LandmarkShape, noise: LandmarkNoise, pose: Pose, there: FloatArray, off: FloatArray
) -> FloatArray:
    """Inverse variances (468, 3): less where a landmark is hidden, or far off (Cauchy)."""
    away = (off[:, :2] ** 2 / noise.whole[:, :2]).sum(axis=1) / LANDMARK_EVIDENCE.stray**2
    return np.asarray((in_view(shape.normals, pose, there) / (1 + away))[:, None] / noise.variance)


def without_rest(whole: Equations, kept: int) -> Equations:
    """The equations with all but the first `kept` integrated out, their prior a unit Gaussian."""
    a, b = slice(0, kept), slice(kept, None)
    information, gradient = whole
    own = information[b, b] + np.eye(len(gradient) - kept)
    gain = np.linalg.solve(own, information[b, a])
    return Equations(information[a, a] - information[a, b] @ gain, gradient[a] - gradient[b] @ gain)


def pupil_equations(
    pupils: FloatArray, modes: FloatArray, pivot: FloatArray, seen: FloatArray, camera: Camera,
    pose: Pose,
    axes: FloatArray,
) -> Equations:  # fmt: skip
    """Equations of the pupils `seen` (2, 2), px, for pose (6) and identity (K).

    The head's own `pupils` are (2, 3), mm; `modes` (K, 2, 3) are how they move with the identity,
    and `axes` (2, 2) those of the face in the picture, as in `Landmarks.axes`.
    """
    there = pose.apply(pupils)
    pixel = there[:, 2].mean() / camera.matrix[0, 0]
    off = ((seen - camera.project(there)) * pixel @ axes.T).ravel()
    moved = np.concatenate([pose_moves(there - pose.apply(pivot)), modes @ pose.rotation.T])
    depth = there[:, 2:]
    scale = np.diag(camera.matrix)[:2] * pixel / depth
    across = (moved[..., :2] - there[:, :2] / depth * moved[..., 2:]) * scale
    slope = (across @ axes.T).reshape(-1, 4)
    common = np.tile(np.diag(np.square(HEAD_POSE.gaze)), (2, 2))
    precision = np.linalg.inv(
        common + (HEAD_POSE.pupil_noise**2 + (HEAD_POSE.pixel_noise * pixel) ** 2) * np.eye(4)
    )
    return Equations(slope @ precision @ slope.T, -slope @ precision @ off)
