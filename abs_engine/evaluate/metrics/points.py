"""Distances of points (T, N, 3), mm, from their truth, their jitter, and other coordinates."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import nearest_rotation, rotations
from abs_engine.evaluate.metrics.bootstrap import compared, mean_of_given


def squared_distance(estimated: ArrayLike, truth: ArrayLike) -> FloatArray:
    """Mean over the points given of the squared distance, (T,) mm^2; NaN where there are none.

    The points are as they are, without any alignment. The square root of the mean over frames is
    their root mean square (RMS) error: of lip points in head coordinates, the engine's headline
    figure.

    Raises
    ------
    ParameterError
        If the shapes differ, or no frame was tracked.
    """
    found, true = _points(estimated, truth)
    return mean_of_given(((found - true) ** 2).sum(axis=2))


def vertex_rms(estimated: ArrayLike, truth: ArrayLike) -> FloatArray:
    """RMS distance of each point over the frames that give it, (N,) mm: a clip's error map."""
    found, true = _points(estimated, truth)
    return np.asarray(np.sqrt(mean_of_given(((found - true) ** 2).sum(axis=2).T)))


def without_constant_offset(estimated: ArrayLike, truth: ArrayLike) -> FloatArray:
    """Estimated points (T, N, 3) after the rigid motion that brings a clip closest to the truth.

    A tracker that estimates the head's shape may place its head frame otherwise than the
    truth does. That difference is the same in all frames, and no motion of the lips. One rotation
    and one translation for all frames (not one for each) are fitted by least squares and
    removed; what is left is the error in the lips' shape and movement.

    Parameters
    ----------
    estimated, truth : (T, N, 3) float, mm

    Raises
    ------
    ParameterError
        If the shapes differ, or no frame was tracked.
    """
    found, true = _points(estimated, truth)
    given = np.isfinite(found).all(axis=2)
    a, b = found[given], true[given]
    centre_a, centre_b = a.mean(axis=0), b.mean(axis=0)
    turn = nearest_rotation((a - centre_a).T @ (b - centre_b))
    return np.asarray((found - centre_a) @ turn + centre_b)


def to_camera(points: ArrayLike, rotation: ArrayLike, translation: ArrayLike) -> FloatArray:
    """Points (T, N, 3) of the head frame in the camera frame.

    Parameters
    ----------
    points : (T, N, 3) float, mm, head frame
    rotation : (T, 3) float
        Rotation vectors, head to camera, radians.
    translation : (T, 3) float, mm
    """
    turned = np.asarray(points, np.float64) @ np.swapaxes(
        rotations(np.asarray(rotation, np.float64)), 1, 2
    )
    return np.asarray(turned + np.asarray(translation, np.float64)[:, None])


def to_head(points: ArrayLike, rotation: ArrayLike, translation: ArrayLike) -> FloatArray:
    """Points (T, N, 3) of the camera frame in the head frame: the inverse of `to_camera`."""
    moved = np.asarray(points, np.float64) - np.asarray(translation, np.float64)[:, None]
    return np.asarray(moved @ rotations(np.asarray(rotation, np.float64)))


def _points(estimated: ArrayLike, truth: ArrayLike) -> tuple[FloatArray, FloatArray]:
    remedy = "give (T, N, 3) of the same frames and the same points"
    found, true = compared(estimated, truth, "points", (None, None, 3), remedy)
    if not np.isfinite(found).all(axis=2).any():
        raise ParameterError("no frame was tracked", "look at the overlay of the run")
    return found, true


def acceleration_error(estimated: ArrayLike, truth: ArrayLike, rate: float) -> FloatArray:
    """Mean over points of the size of the error's second difference, (T,) mm/s^2.

    The acceleration error of Kanazawa et al., Learning 3D human dynamics from video, CVPR (2019),
    here in mm/s^2. NaN in the first and the last frame and beside lost frames;
    a point counts where it is given in three frames in a row. Points are (T, N, 3), mm, `rate`
    frames per second.
    """
    second = _second_difference(estimated, truth)
    return mean_of_given(np.linalg.norm(second, axis=2)) * rate**2


def noise_level(estimated: ArrayLike, truth: ArrayLike) -> FloatArray:
    """Mean square of the error's second difference over six, (T,) mm^2.

    For an error that is white noise, the square root of the mean over frames is the noise's RMS
    length; a slow drift leaves it at 0. This is the residual variance of Gasser, Sroka & Jennen-
    Steinmetz, Biometrika 73 (1986), for equal steps: (1, -2, 1) / sqrt(6). NaN as in
    `acceleration_error`.
    """
    return mean_of_given((_second_difference(estimated, truth) ** 2).sum(axis=2)) / 6.0


def _second_difference(estimated: ArrayLike, truth: ArrayLike) -> FloatArray:
    """Of the error, (T, N, 3), with NaN in the first and the last frame."""
    remedy = "give the same frames and the same points"
    found, true = compared(estimated, truth, "points", (None, None, None), remedy)
    error = found - true
    second = np.full(error.shape, np.nan)
    second[1:-1] = error[:-2] - 2 * error[1:-1] + error[2:]
    return second
