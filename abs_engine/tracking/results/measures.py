"""Measures of lips, jaw and head that phoneticians use, from what a run has found of its frames.

Nothing is smoothed. A number that needs a frame without numbers, or one of another shot, is NaN, so
velocities never span one. The head's frame is right-handed, x to the subject's left, y up, z out of
the face; its origin is the midpoint between the ear canals.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.geometry import Pose
from abs_engine.face.base import RINGS, Face
from abs_engine.io.assets import CLOSED_APERTURE

UPPER, LOWER = 3, 9  # the outer lips' middles, points 51 and 57 of the usual 68
ANGLES = ("head_pitch", "head_yaw", "head_roll")
LIPS = ("upper_protrusion", "lower_protrusion", "opening_area", "lip_area")
VELOCITIES = {
    "aperture_velocity": "aperture",
    "width_velocity": "width",
    "jaw_velocity": "jaw_opening",
}
"""Velocities, and the curves that they are those of."""
OF_FRAME = (*LIPS, "jaw_opening", *ANGLES)
"""Measures of a frame by itself, which `of_frame` gives."""
NAMES = (*LIPS, "jaw_opening", *VELOCITIES, *ANGLES)
"""Columns of ``results.csv`` that are measured here."""

_UP = np.array([0.0, -1.0, 0.0])  # the picture's, in the camera's frame


@dataclass(frozen=True)
class Closure:
    """Lips that touch for a while: the aperture is below `CLOSED_APERTURE`.

    Parameters
    ----------
    first, last : int
        Numbers of its first and last frame.
    onset, release : float
        Seconds at which the aperture crosses the limit, on a straight line between two frames; NaN
        where the frame before or after has no aperture, is of another shot, or there is none.
    least : float
        The smallest aperture, mm.
    """

    first: int
    last: int
    onset: float
    release: float
    least: float


def of_frame(face: Face, vertices: FloatArray | None, pose: Pose | None) -> dict[str, float]:
    """All of `OF_FRAME`, in mm, mm^2 and degrees.

    Vertices are (V, 3), mm, head frame, of the face's scene; None where the lips were not found.
    The pose is head to camera.

    mm: `upper_protrusion` and `lower_protrusion`, z of the outer lips' middles; `jaw_opening`, how
    far the lower teeth lie below their place at rest, NaN for a face without teeth. mm^2, seen
    along z: `opening_area` between the inner contours, `lip_area` within the outer one. Degrees:
    `head_pitch` (up is positive), `head_yaw` (to the subject's left), `head_roll` (to the subject's
    right shoulder), 0, 0, 0 for an upright head that looks into the lens, see `angles`.
    """
    turned = dict(zip(ANGLES, angles(pose), strict=True))
    if vertices is None:
        return dict.fromkeys(OF_FRAME, np.nan) | turned
    outer, upper, lower = (vertices[face.rings[name]] for name in RINGS)
    points = vertices[face.rings["points"]]
    return {
        "upper_protrusion": float(points[UPPER, 2]),
        "lower_protrusion": float(points[LOWER, 2]),
        "opening_area": opening_area(upper, lower),
        "lip_area": abs(enclosed(outer)),
        "jaw_opening": jaw_opening(face, vertices),
        **turned,
    }


def cuts(arrays: Mapping[str, NDArray[Any]]) -> BoolArray:
    """Mask (T,) of the frames that begin another shot, of a run's arrays; of old ones, none."""
    none = np.zeros(len(arrays["aperture"]), bool)
    return np.asarray(arrays.get("cut", none), bool)


def velocities(
    curves: Mapping[str, FloatArray], time: FloatArray, cut: BoolArray
) -> dict[str, FloatArray]:
    """Those of `VELOCITIES` whose curves (T,) are given: mm/s, see `velocity`."""
    return {v: velocity(curves[of], time, cut) for v, of in VELOCITIES.items() if of in curves}


def jaw_opening(face: Face, vertices: FloatArray) -> float:
    """Distance of the lower teeth of vertices (V, 3) below their place at rest, mm, or NaN."""
    jaw = face.rings.get("jaw")
    if jaw is None or not len(jaw):
        return float("nan")
    rest = face.scene.vertices(face.starts[0])
    return float(np.mean(rest[jaw, 1], dtype=np.float64) - np.mean(vertices[jaw, 1]))


def enclosed(contour: FloatArray) -> float:
    """Signed area within a closed contour (N, 3) seen along z, mm^2 (the shoelace formula)."""
    x, y = contour[:, 0], contour[:, 1]
    return float(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def opening_area(upper: FloatArray, lower: FloatArray) -> float:
    """Area between the inner contours (N, 3) and (M, 3), corner to corner, seen along z, mm^2.

    Where lips overlap there is none.
    """
    upper, lower = (line[np.argsort(line[:, 0], kind="stable")] for line in (upper, lower))
    across = np.unique(np.concatenate([upper[:, 0], lower[:, 0]]))
    both = (np.interp(across, line[:, 0], line[:, 1]) for line in (upper, lower))
    gap = np.subtract(*both).clip(min=0)
    return float(np.trapezoid(gap, across))


def velocity(values: FloatArray, time: FloatArray, cut: BoolArray) -> FloatArray:
    """Central differences (T,) of values (T,), per second; NaN at the ends and beside a NaN.

    A frame that begins another shot (`cut`, (T,)) is the end of one, and the start of the next.
    """
    slope = np.full(len(values), np.nan)
    if len(values) > 2:
        slope[1:-1] = (values[2:] - values[:-2]) / (time[2:] - time[:-2])
    slope[np.isnan(values) | cut | np.roll(cut, -1)] = np.nan
    return slope


def angles(pose: Pose | None) -> tuple[float, float, float]:
    """Pitch, yaw and roll of a head that looks into the lens or past it.

    With t the place of the head's origin before the camera, the lens lies towards z = -t / |t|.
    Right-handed axes x, y, z with y as near to the picture's up u as can be have x along u x z and
    y = z x x. The head is turned away from them by its yaw about y, then about its own axes by
    pitch and roll: (x y z)^T R = Ry(yaw) Rx(-pitch) Rz(roll).

    The pose is head to camera, the head not straight above or below the lens. Degrees: up, to the
    subject's left and to the subject's right shoulder are positive; NaN of an unknown pose.
    """
    if pose is None:
        return (np.nan,) * 3
    z = -pose.translation / np.linalg.norm(pose.translation)
    x = np.cross(_UP, z)
    x /= np.linalg.norm(x)
    turn = np.array([x, np.cross(z, x), z]) @ pose.rotation
    pitch = np.arcsin(np.clip(turn[1, 2], -1, 1))
    yaw = np.arctan2(turn[0, 2], turn[2, 2])
    roll = np.arctan2(turn[1, 0], turn[1, 1])
    return float(np.degrees(pitch)), float(np.degrees(yaw)), float(np.degrees(roll))


def closures(aperture: FloatArray, time: FloatArray, cut: BoolArray) -> list[Closure]:
    """Each time that lips close, of apertures (T,) in mm at times (T,) in seconds.

    None goes on where another shot begins (`cut`, (T,)).
    """
    closed = aperture < CLOSED_APERTURE
    begins = closed & (cut | ~np.r_[False, closed[:-1]])
    ends = closed & ~np.r_[closed[1:] & ~cut[1:], False]
    pairs = zip(np.flatnonzero(begins).tolist(), np.flatnonzero(ends).tolist(), strict=True)
    return [
        Closure(
            first, last, _crossing(aperture, time, cut, first - 1),
            _crossing(aperture, time, cut, last), float(aperture[first : last + 1].min()),
        )
        for first, last in pairs
    ]  # fmt: skip


def closure_arrays(found: Sequence[Closure]) -> dict[str, NDArray[Any]]:
    """First and last frames of closures, and their onsets and releases, as a run has them."""
    return {
        "closure_frames": np.array([(c.first, c.last) for c in found], np.int64).reshape(-1, 2),
        "closure_times": np.array([(c.onset, c.release) for c in found]).reshape(-1, 2),
    }


def _crossing(aperture: FloatArray, time: FloatArray, cut: BoolArray, before: int) -> float:
    """Time at which the aperture crosses the limit between two frames, s; NaN where unknown."""
    if before < 0 or before + 1 >= len(aperture) or cut[before + 1]:
        return float("nan")
    one, other = aperture[before], aperture[before + 1]
    share = (CLOSED_APERTURE - one) / (other - one)
    return float(time[before] + share * (time[before + 1] - time[before]))
