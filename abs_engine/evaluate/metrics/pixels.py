"""Landmarks in the picture: errors in pixels, and over the distance of the eyes."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from abs_engine.core.arrays import FloatArray
from abs_engine.evaluate.metrics.bootstrap import compared, mean_of_given

OUTER_CORNERS = 36, 45


def interocular(landmark_68: ArrayLike) -> FloatArray:
    """Distance (T,) between the outer corners of the eyes, points 36 and 45 of (T, 68, 2 or 3)."""
    points = np.asarray(landmark_68, np.float64)
    right, left = OUTER_CORNERS
    return np.asarray(np.linalg.norm(points[:, right] - points[:, left], axis=1))


def pixel_error(estimated: ArrayLike, truth: ArrayLike) -> FloatArray:
    """Mean over points of the squared distance, (T,) px^2, of points (T, N, 2).

    Points that are NaN in a frame were not given there and are left out; a frame without any is
    NaN.

    Raises
    ------
    ParameterError
        If the shapes differ.
    """
    return mean_of_given(_distance(estimated, truth) ** 2)


def normalised_error(estimated: ArrayLike, truth: ArrayLike, scale: ArrayLike) -> FloatArray:
    """Mean over points of the distance over `scale`, (T,): the normalised mean error.

    With the true distance between the outer corners of the eyes (`interocular`) as the scale it
    is the error of 300-W (Sagonas et al., 300 faces in-the-wild challenge, Image and Vision
    Computing 47 (2016)).

    Parameters
    ----------
    estimated, truth : (T, N, 2) float, px
    scale : (T,) float, px

    Raises
    ------
    ParameterError
        If the shapes differ.
    """
    return np.asarray(mean_of_given(_distance(estimated, truth)) / np.asarray(scale, np.float64))


def _distance(estimated: ArrayLike, truth: ArrayLike) -> FloatArray:
    remedy = "give (T, N, 2) of the same frames and the same points"
    found, true = compared(estimated, truth, "pixels", (None, None, 2), remedy)
    return np.asarray(np.linalg.norm(found - true, axis=2))
