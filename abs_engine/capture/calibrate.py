"""Cameras from pictures of a board: intrinsics, distortion, and how two cameras stand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from abs_engine.capture.board import Corners
from abs_engine.capture.settings import CAPTURE
from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.errors import CalibrationError
from abs_engine.core.geometry import Pose

_FLAGS = cv2.CALIB_FIX_K3
"""Two radial and two tangential coefficients, which a few pictures can tell."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """A camera, and how well the pictures agree with it.

    Parameters
    ----------
    error : float, px
        Root mean square distance of the corners from where the camera would see them.
    focal_deviation : float, px
        Standard deviation of the focal length, the larger of x and y.
    centre_deviation : float, px
        The same of the principal point.
    poses : tuple of Pose
        Board to camera, for each picture.
    """

    camera: Camera
    error: float
    focal_deviation: float
    centre_deviation: float
    poses: tuple[Pose, ...]


def calibrate_camera(pictures: Sequence[Corners], size: tuple[int, int]) -> Calibration:
    """Intrinsics and distortion of a camera from a board in each picture (Zhang 2000, by OpenCV).

    `size` is the pictures' (width, height), px.

    Raises
    ------
    CalibrationError
        If there are too few pictures, the board stands alike in all of them, or they leave the
        focal length open.
    """
    if not pictures:
        raise CalibrationError(
            "the board was found in no picture",
            "check --squares (columns before rows), --board, --marker and --dictionary",
        )
    if len(pictures) < CAPTURE.least_pictures:
        raise CalibrationError(
            f"the board was found in {len(pictures)} pictures, {CAPTURE.least_pictures} are needed",
            "take more, with the whole board in sight and sharp",
        )
    done, tangential = _solved(pictures, size, _FLAGS)
    if (np.abs(done.camera.distortion[2:4]) < CAPTURE.tangential * tangential).all():
        done, _ = _solved(pictures, size, _FLAGS | cv2.CALIB_ZERO_TANGENT_DIST)
    _check(done.poses, done.camera.matrix, done.focal_deviation)
    return done


def _solved(
    pictures: Sequence[Corners], size: tuple[int, int], flags: int
) -> tuple[Calibration, FloatArray]:
    """OpenCV's solution for the pictures; and the tangential coefficients' deviations (2,)."""
    try:
        error, matrix, distortion, turns, shifts, deviations, _, _ = cv2.calibrateCameraExtended(
            [p.places.astype(np.float32) for p in pictures],
            [p.pixels.astype(np.float32) for p in pictures],
            size, np.eye(3), np.zeros(5), flags=flags,
        )  # fmt: skip
    except cv2.error as failure:
        raise CalibrationError(
            "the pictures of the board do not agree with any camera", "take them again"
        ) from failure
    poses = tuple(Pose.from_vectors(r, t) for r, t in zip(turns, shifts, strict=True))
    camera = Camera(np.asarray(matrix, np.float64), size, np.asarray(distortion, np.float64))
    spread = np.asarray(deviations, np.float64).ravel()  # fx, fy, cx, cy, k1, k2, p1, p2, ...
    focal, centre = float(spread[:2].max()), float(spread[2:4].max())
    return Calibration(camera, float(error), focal, centre, poses), spread[6:8]


@dataclass(frozen=True, eq=False)
class StereoCalibration:
    """Pose of a second camera relative to the first.

    Parameters
    ----------
    pose : Pose
        First camera's frame to the second's.
    error : float, px
    """

    pose: Pose
    error: float

    @property
    def distance(self) -> float:
        """Distance between the two cameras, mm."""
        return float(np.linalg.norm(self.pose.translation))


def calibrate_stereo(
    pairs: Sequence[tuple[Corners, Corners]], first: Calibration, second: Calibration
) -> StereoCalibration:
    """Pose of two cameras relative to each other, from a board that both see at the same moments.

    Raises
    ------
    CalibrationError
        If fewer than three pairs have enough corners in common, the pairs do not agree on how the
        cameras stand, or both are in the same place.
    """
    shared = [a.common(b) for a, b in pairs]
    shared = [(a, b) for a, b in shared if len(a.ids) >= CAPTURE.least_common]
    if len(shared) < CAPTURE.least_pictures:
        raise CalibrationError(
            f"both cameras see the board in {len(shared)} pairs of pictures, "
            f"{CAPTURE.least_pictures} are needed",
            "take more, at the same moments, in the same order",
        )
    error, *_, rotation, translation, _, _ = cv2.stereoCalibrate(
        [a.places.astype(np.float32) for a, _ in shared],
        [a.pixels.astype(np.float32) for a, _ in shared],
        [b.pixels.astype(np.float32) for _, b in shared],
        first.camera.matrix, first.camera.distortion,
        second.camera.matrix, second.camera.distortion, first.camera.size,
        flags=cv2.CALIB_FIX_INTRINSIC,
    )  # fmt: skip
    pose = Pose(np.asarray(rotation, np.float64), np.asarray(translation, np.float64))
    done = StereoCalibration(pose, float(error))
    _check_pair(done, first, second)
    return done


def _check_pair(done: StereoCalibration, first: Calibration, second: Calibration) -> None:
    """Refuse cameras whose pictures are not of the same moments, or that are in the same place."""
    alone = max(first.error, second.error)
    if done.error > max(CAPTURE.together * alone, CAPTURE.small_error * max(first.camera.size)):
        raise CalibrationError(
            f"both cameras together are off by {done.error:.2f} px RMS, each alone by at most "
            f"{alone:.2f}",
            "give pictures of the same moments, in the same order",
        )
    if done.distance < CAPTURE.cameras_apart * np.median([p.translation[2] for p in first.poses]):
        raise CalibrationError(
            f"both cameras are in the same place ({done.distance:.1f} mm apart)",
            "give each camera's own pictures",
        )


def _check(poses: Sequence[Pose], matrix: FloatArray, deviation: float) -> None:
    normals = np.stack([p.rotation[:, 2] for p in poses])
    widest = float(np.arccos(np.clip(np.abs(normals @ normals.T), -1, 1)).max())
    if widest < np.radians(CAPTURE.tilt):
        raise CalibrationError(
            f"the board stands alike in all pictures (turned by at most {np.degrees(widest):.1f} "
            "degrees), which leaves the focal length open",
            "tilt it to all sides, by 20 to 45 degrees",
        )
    focal = float(min(matrix[0, 0], matrix[1, 1]))
    if not deviation < CAPTURE.vague * focal:
        raise CalibrationError(
            f"the pictures leave the focal length open ({focal:.0f} +- {deviation:.0f} px)",
            "take more, near and far, with the board tilted to all sides",
        )
