"""Numbers that say how far a track is from the truth. Lengths in mm.

Points are (T, N, 3): T frames of N points. A frame in which an estimate is not finite was not
tracked; it is left out of every number, and the caller reports how many there are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from abs_engine.errors import ParameterError
from abs_engine.geometry import rotations

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PointError:
    """Distance between points and their truth.

    Parameters
    ----------
    overall : float
        sqrt of the mean, over all points of all tracked frames, of the squared distance.
    per_frame : (T,) float64
        The same over the points of one frame; NaN where the frame was not tracked.
    """

    overall: float
    per_frame: FloatArray


@dataclass(frozen=True)
class CurveError:
    """How a curve differs from its truth.

    Parameters
    ----------
    rms, bias : float
        Root mean square and mean of estimate - truth.
    correlation : float
        Pearson's; NaN where one of the curves is constant.
    """

    rms: float
    bias: float
    correlation: float


@dataclass(frozen=True)
class Detection:
    """Frames found against frames that are there.

    Parameters
    ----------
    precision : float
        Share of the found frames that are true; NaN where none was found.
    recall : float
        Share of the true frames that were found; NaN where there is none.
    """

    precision: float
    recall: float


def lip_rms_mm(estimated: ArrayLike, truth: ArrayLike) -> PointError:
    """RMS distance of points as they are, without any alignment ("raw").

    With lip points in head coordinates this is the engine's headline figure. The same function
    serves for points in camera coordinates (see `to_camera`).

    Parameters
    ----------
    estimated, truth : (T, N, 3) float, mm, in one and the same frame of reference

    Returns
    -------
    PointError

    Raises
    ------
    ParameterError
        If the shapes differ, or no frame was tracked.
    """
    found, true = _points(estimated, truth)
    squared = ((found - true) ** 2).sum(axis=2).mean(axis=1)
    return PointError(float(np.sqrt(squared[_tracked(found)].mean())), np.sqrt(squared))


def without_constant_offset(estimated: ArrayLike, truth: ArrayLike) -> FloatArray:
    """Estimated points after the one rigid motion that brings the whole clip closest to the truth.

    A tracker that estimates the head's shape may place its head frame otherwise than the
    truth does. That difference is the same in all frames, and no motion of the lips. One rotation
    and one translation for all frames (not one for each) are fitted by least squares and
    removed; what is left is the error in the lips' shape and movement.

    Parameters
    ----------
    estimated, truth : (T, N, 3) float, mm

    Returns
    -------
    (T, N, 3) float64

    Raises
    ------
    ParameterError
        If the shapes differ, or no frame was tracked.

    Notes
    -----
    The rotation is Kabsch's (1976), by singular value decomposition; it never mirrors.
    """
    found, true = _points(estimated, truth)
    chosen = _tracked(found)
    a, b = found[chosen].reshape(-1, 3), true[chosen].reshape(-1, 3)
    centre_a, centre_b = a.mean(axis=0), b.mean(axis=0)
    u, _, vt = np.linalg.svd((a - centre_a).T @ (b - centre_b))
    mirror = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    return np.asarray((found - centre_a) @ (u @ mirror @ vt) + centre_b)


def to_camera(points: ArrayLike, rotation: ArrayLike, translation: ArrayLike) -> FloatArray:
    """Points (T, N, 3) of the head frame in the camera frame.

    Parameters
    ----------
    points : (T, N, 3) float, mm, head frame
    rotation : (T, 3) float
        Rotation vectors, head to camera, radians.
    translation : (T, 3) float, mm

    Returns
    -------
    (T, N, 3) float64, mm
    """
    turned = np.asarray(points, np.float64) @ np.swapaxes(
        rotations(np.asarray(rotation, np.float64)), 1, 2
    )
    return np.asarray(turned + np.asarray(translation, np.float64)[:, None])


def curve_error(estimated: ArrayLike, truth: ArrayLike) -> CurveError:
    """Difference and correlation of two curves (T,), such as lip aperture or width.

    Raises
    ------
    ParameterError
        If the lengths differ, or no frame was tracked.
    """
    found, true = np.asarray(estimated, np.float64), np.asarray(truth, np.float64)
    if found.shape != true.shape or found.ndim != 1:
        raise ParameterError(
            f"curves of shapes {found.shape} and {true.shape} cannot be compared",
            "compare the same frames of one clip",
        )
    chosen = np.isfinite(found)
    if not chosen.any():
        raise ParameterError("no frame was tracked", "look at the overlay of the run")
    found, true = found[chosen], true[chosen]
    error = found - true
    constant = np.ptp(found) == 0 or np.ptp(true) == 0
    correlation = np.nan if constant else float(np.corrcoef(found, true)[0, 1])
    return CurveError(float(np.sqrt((error**2).mean())), float(error.mean()), correlation)


def closure(estimated: ArrayLike, truth: ArrayLike) -> Detection:
    """Precision and recall, counted in frames, of the frames (T,) in which lips are closed.

    Raises
    ------
    ParameterError
        If the lengths differ.
    """
    found, true = np.asarray(estimated, bool), np.asarray(truth, bool)
    if found.shape != true.shape:
        raise ParameterError(
            f"{found.size} frames cannot be compared with {true.size}",
            "compare the same frames of one clip",
        )
    hits = float((found & true).sum())
    precision = hits / found.sum() if found.any() else np.nan
    recall = hits / true.sum() if true.any() else np.nan
    return Detection(float(precision), float(recall))


def spikes(curve: ArrayLike, threshold: float) -> int:
    """Number of frames that stand out from both neighbours, to one side, by more than `threshold`.

    No lip moves there and back within two frames; such a frame is a tracker's slip. The first and
    the last frame, and neighbours of frames that were not tracked, never count.
    """
    values = np.asarray(curve, np.float64)
    before, here, after = values[:-2], values[1:-1], values[2:]
    above = here - np.maximum(before, after) > threshold
    below = np.minimum(before, after) - here > threshold
    return int((above | below).sum())


def _points(estimated: ArrayLike, truth: ArrayLike) -> tuple[FloatArray, FloatArray]:
    found, true = np.asarray(estimated, np.float64), np.asarray(truth, np.float64)
    if found.shape != true.shape or found.ndim != 3 or found.shape[2] != 3:
        raise ParameterError(
            f"points of shapes {found.shape} and {true.shape} cannot be compared",
            "give (T, N, 3) of the same frames and the same points",
        )
    if not _tracked(found).any():
        raise ParameterError("no frame was tracked", "look at the overlay of the run")
    return found, true


def _tracked(points: FloatArray) -> NDArray[np.bool_]:
    return np.asarray(np.isfinite(points).all(axis=(1, 2)))
