"""Jitter: what shakes from frame to frame although the face does not."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from abs_engine.core.arrays import FloatArray
from abs_engine.evaluate.metrics.bootstrap import compared, mean_of_given


def acceleration_error(estimated: ArrayLike, truth: ArrayLike, rate: float) -> FloatArray:
    """Mean over points of the size of the error's second difference, (T,) mm/s^2.

    The acceleration error of Kanazawa et al., Learning 3D human dynamics from video, CVPR (2019),
    here in mm/s^2. NaN in the first and the last frame and beside lost frames;
    a point counts where it is given in three frames in a row.

    Parameters
    ----------
    estimated, truth : (T, N, 3) float, mm
    rate : float
        Frames per second.
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
