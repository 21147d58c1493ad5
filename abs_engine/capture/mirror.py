"""A mirror before the camera, found from pictures that show a board beside its mirror image."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.optimize import least_squares

from abs_engine.capture.board import Corners
from abs_engine.capture.settings import CAPTURE
from abs_engine.capture.view import Plane, View
from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.errors import CalibrationError
from abs_engine.core.geometry import Pose


@dataclass(frozen=True, eq=False)
class MirrorCalibration:
    """A mirror's plane.

    Parameters
    ----------
    rectangle : (4, 3) float64, mm, camera frame
        A rectangle in the plane that holds all that was seen in it; the mirror may be larger.
    error : float, px
        Root mean square distance of the corners, direct and mirrored, from where they should be.
    """

    plane: Plane
    rectangle: FloatArray
    error: float


def calibrate_mirror(pairs: Sequence[tuple[Corners, Corners]], camera: Camera) -> MirrorCalibration:
    """The plane of a mirror, from a board and its image in the same pictures.

    A flat board's mirror image could as well be another board: its pose and that of the board
    itself give a plane to start from. Plane and poses are then moved until all corners fit best.
    Pairs are the board as seen directly, and in the mirror, for each picture.

    Raises
    ------
    CalibrationError
        If there is no pair, or no plane comes near to explaining them.
    """
    if not pairs:
        raise CalibrationError(
            "no picture shows the board both directly and in the mirror",
            "take some where both are whole and sharp; the board must be a ChArUco",
        )
    poses = [_pose(direct, camera) for direct, _ in pairs]
    start = _plane(pairs, poses, camera)
    fit = least_squares(
        _residuals, np.concatenate([start.normal * start.distance, *map(_vector, poses)]),
        args=(pairs, camera), x_scale="jac", method="lm",
    )  # fmt: skip
    plane = _plane_of(fit.x)
    error = float(np.sqrt((fit.fun.reshape(-1, 2) ** 2).sum(axis=1).mean()))
    if not error < CAPTURE.mirror_error:
        raise CalibrationError(
            f"no flat mirror explains the pictures (error {error:.1f} px)",
            "check that the mirror did not move and the board's size is right",
        )
    return MirrorCalibration(plane, _rectangle(plane, pairs, camera), error)


def _pose(corners: Corners, camera: Camera) -> Pose:
    solved, turn, shift = cv2.solvePnP(
        corners.places, corners.pixels, camera.matrix, camera.distortion, flags=cv2.SOLVEPNP_IPPE
    )
    if not solved:
        raise CalibrationError("the board's pose cannot be found", "take sharper pictures")
    return Pose.from_vectors(turn, shift)


def _plane(
    pairs: Sequence[tuple[Corners, Corners]], poses: Sequence[Pose], camera: Camera
) -> Plane:
    """A plane midway between the boards and the boards that their images seem to be."""
    moved, middle = [], []
    for (direct, image), pose in zip(pairs, poses, strict=True):
        both, other = direct.common(image)
        there = _pose(other, camera).apply(other.places)
        here = pose.apply(both.places)
        moved.append(there - here)
        middle.append((there + here) / 2)
    if sum(map(len, moved)) < 1:
        raise CalibrationError("board and image share no corner", "show more of the board")
    normal = np.concatenate(moved).mean(axis=0)
    normal /= np.linalg.norm(normal)
    return Plane(normal, float(-np.concatenate(middle).mean(axis=0) @ normal))


def _vector(pose: Pose) -> FloatArray:
    return np.concatenate([pose.rotation_vector, pose.translation])


def _plane_of(values: FloatArray) -> Plane:
    distance = float(np.linalg.norm(values[:3]))
    return Plane(values[:3] / distance, distance)


def _residuals(
    values: FloatArray, pairs: Sequence[tuple[Corners, Corners]], camera: Camera
) -> FloatArray:
    plane, out = _plane_of(values), []
    for (direct, image), vector in zip(pairs, values[3:].reshape(-1, 6), strict=True):
        pose = Pose.from_vectors(vector[:3], vector[3:])
        for corners, mirror in ((direct, None), (image, plane)):
            at = View(camera, pose, mirror).project(corners.places)
            out.append((at - corners.pixels).ravel())
    return np.concatenate(out)


def _rectangle(
    plane: Plane, pairs: Sequence[tuple[Corners, Corners]], camera: Camera
) -> FloatArray:
    """Bounds, in the plane, of where the lines of sight to the images meet it."""
    view = View(camera)
    sight = np.concatenate([view.directions(image.pixels) for _, image in pairs])
    hits = sight * (-plane.distance / (sight @ plane.normal))[:, None]
    down = np.array([0.0, 1.0, 0.0]) - plane.normal[1] * plane.normal
    if np.linalg.norm(down) < 0.1:  # the mirror lies below or above
        down = np.array([0.0, 0.0, 1.0]) - plane.normal[2] * plane.normal
    down /= np.linalg.norm(down)
    axes = np.stack([np.cross(down, plane.normal), down])
    flat = hits @ axes.T
    low, high = flat.min(axis=0), flat.max(axis=0)
    low, high = (
        low - CAPTURE.mirror_margin * (high - low),
        high + CAPTURE.mirror_margin * (high - low),
    )
    foot = -plane.distance * plane.normal
    corners = np.array([[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]])
    return np.asarray(foot + corners @ axes)
