"""The equations of matches between two frames: how poses, postures and shape move their places."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.core.pose import pose_moves
from abs_engine.tracking.landmark.head_equations import Equations
from abs_engine.tracking.settings.head import HEAD_POSE
from abs_engine.tracking.texture.head_texture import HeadBody, HeadView, Matches, picture_motion


@dataclass(frozen=True, eq=False)
class MatchEquations:
    """Matches, linearised.

    Parameters
    ----------
    residual : (N, 2) float64, px
        Where the second frame shows the points, less where the head puts them.
    first : (6 + U, N, 2) float64
        By how much the head puts them elsewhere for a step of the first frame's pose, and for a
        standard deviation of each mode of its upper face, see `HeadBody.upper`; empty where the
        identity is not asked for.
    second : (6 + U, N, 2) or (6 + M, N, 2) float64
        The same for the second frame. Where the identity is not asked for, all modes of the posture
        take the place of the upper face's.
    identity : (K, N, 2) float64
    weight : (N,) float64
        Inverse variances, robust.
    """

    residual: FloatArray
    first: FloatArray
    second: FloatArray
    identity: FloatArray
    weight: FloatArray

    @property
    def normal(self) -> Equations:
        """Normal equations of the first frame, the second and the identity, in this order."""
        slope = np.concatenate([self.first, self.second, self.identity])
        flat = slope.reshape(len(slope), -1)
        weighed = flat * np.repeat(self.weight, 2)
        return Equations(weighed @ flat.T, -(weighed @ self.residual.ravel()))

    def off(self, sigma: float) -> float:
        """Median distance of the matches from where the head puts them, in `sigma`, px."""
        return float(np.median(np.linalg.norm(self.residual, axis=1))) / sigma


def linearised(
    body: HeadBody, found: Matches, first: HeadView, second: HeadView, camera: Camera
) -> MatchEquations:
    """The matches' equations.

    A point stays on its ray in the first frame: where shape, pose or posture change, it slides
    along the surface.
    """
    points = found.of(second.vertices)
    return linearised_at(body, found, first, second.pose, points, camera)


def linearised_at(
    body: HeadBody, found: Matches, first: HeadView, pose: Pose, points: FloatArray, camera: Camera,
    who: bool = True,
) -> MatchEquations:  # fmt: skip
    """The same with the matches at points (N, 3) of the head, mm, and its pose in the second frame.

    If `who`, for the poses and upper faces of both frames and for the identity; otherwise for the
    pose and the whole posture of the second frame alone.
    """
    here, normal = found.of(first.vertices), found.of(first.normals)
    eye = -first.pose.rotation.T @ first.pose.translation
    ray = _rays(found.first, first.camera or camera) @ first.pose.rotation
    steep = np.minimum((ray * normal).sum(axis=1, keepdims=True), HEAD_POSE.grazing)
    slide = eye + ray * ((here - eye) * normal).sum(axis=1, keepdims=True) / steep - here
    far = np.maximum(np.linalg.norm(slide, axis=1, keepdims=True), 1e-9)
    slide *= np.minimum(1.0, HEAD_POSE.most_slide / far)

    point = points + slide
    there = pose.apply(point)
    seen = picture_motion(there, camera)
    own = seen @ pose.rotation  # of a motion in the head's own axes
    moves = _seen(seen, _moves(pose, point, body.pivot))
    before = identity = np.zeros((0, *found.second.shape))
    if who:
        # Where the surface sinks, its points go along their rays of the first frame
        sunk = np.einsum("nij,nj->ni", own, ray / steep)[..., None] * normal[:, None]
        back = _moves(first.pose, here + slide, body.pivot) @ first.pose.rotation
        upper = found.posture[len(found.posture) - body.upper :]
        before = _seen(sunk - own, np.concatenate([back, upper]))
        moves = np.concatenate([moves, _seen(own, upper)])
        identity = _seen(sunk, found.identity)
    else:
        moves = np.concatenate([moves, _seen(own, found.posture)])
    residual = found.second - camera.project(there)
    away = (residual**2).sum(axis=1) / (2 * found.sigma) ** 2
    weight = 1 / (HEAD_POSE.matches_alike * found.sigma**2 * (1 + away))
    return MatchEquations(residual, before, moves, identity, weight)


def _rays(pixels: FloatArray, camera: Camera) -> FloatArray:
    """Unit vectors (N, 3) to pixels (N, 2), camera frame."""
    flat = camera.undistort(pixels)
    rays = np.column_stack([flat, np.ones(len(flat))])
    return np.asarray(rays / np.linalg.norm(rays, axis=1, keepdims=True))


def _seen(by: FloatArray, moves: FloatArray) -> FloatArray:
    """Motion in the picture (D, N, 2) of points that move (D, N, 3), each by its matrix (2, 3)."""
    # 25 times as fast as einsum
    return np.asarray(np.matmul(by, moves.transpose(1, 2, 0)).transpose(2, 0, 1))


def _moves(pose: Pose, points: FloatArray, pivot: FloatArray) -> FloatArray:
    """Motion of points (N, 3) of the head, camera frame, for a step of the pose, (6, N, 3)."""
    return pose_moves(pose.apply(points) - pose.apply(pivot))
