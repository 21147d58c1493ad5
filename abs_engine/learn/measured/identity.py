"""Identity and place of a head by points measured at rest: Gauss-Newton, with its prior."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.geometry import Pose, rotations
from abs_engine.core.pose import pose_moves
from abs_engine.face.shape.dots import ShellPoints
from abs_engine.learn.measured.settings import MEASURED_FACE

_POSE = 6


@dataclass(frozen=True, eq=False)
class PlacedHead:
    """Somebody's head at rest, and where it is among the points.

    Parameters
    ----------
    mean : (V, 3) float64, mm, head frame
        The average head.
    people : (K, V, 3) float32, mm for a standard deviation
        How heads differ.
    identity : (K,) float64
        Standard deviations.
    frame : Pose
        Head frame to the frame of the points.
    """

    mean: FloatArray
    people: NDArray[np.float32]
    identity: FloatArray
    frame: Pose

    @cached_property
    def vertices(self) -> FloatArray:
        """The head (V, 3), mm, head frame."""
        return np.asarray(self.mean + np.tensordot(self.identity, self.people, 1), np.float64)

    def seen(self, points: FloatArray) -> FloatArray:
        """Points (..., 3), mm, of the points' frame in the head's."""
        return self.frame.inverse.apply(points)

    def fitted(
        self, points: FloatArray, places: ShellPoints, across: float, along: float
    ) -> PlacedHead:
        """The head that has its places nearest to points (N, 3), mm, at rest, in their own frame.

        `across` and `along`, mm, are standard deviations of a point's distance from its place,
        across and along the surface.
        """
        wanted = self.seen(points)
        weights = _weights(self.vertices, places, across, along)
        middle = wanted.mean(axis=0)
        columns = np.concatenate([places.at(self.people), -pose_moves(wanted - middle)])
        matrix = np.einsum("nij,knj->nik", weights, columns).reshape(-1, len(columns))
        left = np.einsum("nij,nj->ni", weights, wanted - places.at(self.mean)).ravel()
        count = len(self.people)
        prior = np.r_[
            np.ones(count), np.full(3, 1 / MEASURED_FACE.turn), np.full(3, 1 / MEASURED_FACE.shift)
        ]
        normal = matrix.T @ matrix + np.diag(prior**2)
        found = np.linalg.solve(normal, matrix.T @ left)
        identity, turn, shift = np.split(found, [count, count + 3])
        return replace(self, identity=identity, frame=self._moved(turn, shift, middle))

    def _moved(self, turn: FloatArray, shift: FloatArray, middle: FloatArray) -> Pose:
        """The frame after points turned about their middle and shifted, head frame."""
        back, rotation = self.frame.inverse, rotations(turn[None])[0]
        there = rotation @ (back.translation - middle) + middle + shift
        return Pose(rotation @ back.rotation, there).inverse


def _weights(vertices: FloatArray, places: ShellPoints, across: float, along: float) -> FloatArray:
    """Roots (N, 3, 3) of the information of each point."""
    a, b, c = (vertices[places.corners[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    square = normal[:, :, None] * normal[:, None, :]
    return np.asarray(np.eye(3) / along + (1 / across - 1 / along) * square, np.float64)
