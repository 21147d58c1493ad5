"""Poses that were measured elsewhere, laid on a head that was fitted to landmarks.

Whose head they are of is not known: its unit of length, axes and origin may differ. All three
follow from frames in which the fitted head is found by its landmarks and texture, too.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from abs_engine.core.arrays import BoolArray, FloatArray
from abs_engine.core.errors import FaceNotFoundError, ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.tracking.settings.head import HEAD_POSE
from abs_engine.tracking.settings.preparation import PREPARATION


def aligned(
    given: Sequence[Pose | None], own: Sequence[tuple[int, Pose]], pivot: FloatArray
) -> tuple[Pose | None, ...]:
    """Given poses as poses of the fitted head.

    They are in other axes and from another origin. `own` are frames that have both, and the fitted
    head's pose there; both are aligned at the `pivot` (3,), mm, in its frame, between the lips.

    Raises
    ------
    ParameterError
        If they do not move as the face does.
    FaceNotFoundError
        If no frame has both.
    """
    pairs = [(pose, one) for k, one in own if (pose := given[k]) is not None]
    if not pairs:
        raise FaceNotFoundError("no frame has a pose and a face", "give poses of this video")
    turns = Rotation.from_matrix([one.rotation.T @ other.rotation for one, other in pairs])
    turn = turns.mean()
    off = float(np.rad2deg(np.median((turn.inv() * turns).magnitude())))
    scale, shift, away = _placed(pairs, turn.apply(pivot), pivot)
    if off > HEAD_POSE.given_apart or away > HEAD_POSE.given_away:
        raise ParameterError(
            f"the given poses do not move as the face does: in half of the frames looked at they "
            f"are {off:.0f} degrees and {away:.0f} mm or more off",
            "check that they are of this video, and map the head's axes to the camera's",
        )
    matrix = turn.as_matrix()
    return tuple(None if one is None else _laid(one, matrix, scale, shift, pivot) for one in given)


def _placed(
    pairs: Sequence[tuple[Pose, Pose]], usual: FloatArray, pivot: FloatArray
) -> tuple[float, FloatArray, float]:
    """Scale of given poses, the pivot in their axes (3,), mm, and how far off the median frame is.

    In a head that hardly moves, where the pivot `usual`ly is, in the same axes, separates scale and
    depth.
    """
    turns = np.stack([one.rotation for one, _ in pairs])
    there = np.stack([one.translation for one, _ in pairs])
    wanted = np.stack([other.apply(pivot) for _, other in pairs])

    def off(x: FloatArray) -> FloatArray:
        return np.asarray(x[0] * there + turns @ x[1:] - wanted)

    ratio = float(np.median(wanted[:, 2] / (there + turns @ usual)[:, 2]))
    start = np.r_[ratio, usual]
    for _ in range(2):  # where the origin is off, heads that turned look wrong at first
        near = _together(off(start))

        def residuals(x: FloatArray, near: BoolArray = near) -> FloatArray:
            held = (x[1:] - usual) / HEAD_POSE.given_origin
            return np.concatenate([off(x)[near].ravel() / PREPARATION.pose_deviation[3], held])

        found = least_squares(residuals, start, loss="soft_l1", x_scale=HEAD_POSE.given_step)
        start = found.x
    away = float(np.median(np.linalg.norm(off(found.x), axis=1)))
    return float(found.x[0]), found.x[1:], away


def _together(off: FloatArray) -> BoolArray:
    """Frames (N,) that are off (N, 3), mm, about alike: a small scale would hide a wrong pose."""
    apart = np.linalg.norm(off - np.median(off, axis=0), axis=1)
    return np.asarray(apart <= max(HEAD_POSE.given_away, 3 * float(np.median(apart))))


def _laid(pose: Pose, turn: FloatArray, scale: float, shift: FloatArray, pivot: FloatArray) -> Pose:
    """A pose as that of a head with turned axes, the pivot at `shift` in those of the given one."""
    rotation = pose.rotation @ turn
    there = scale * pose.translation + pose.rotation @ shift
    return Pose(rotation, there - rotation @ pivot)
