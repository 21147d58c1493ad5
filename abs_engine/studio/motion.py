"""Motion of a head: chance, keys, a recording, and out of the picture."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.interpolate import PchipInterpolator

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.studio.scenefile import HeadKey, MotionEntry
from abs_engine.studio.sequence import sway


def head_poses(
    motion: MotionEntry,
    times: FloatArray,
    rng: np.random.Generator,
    turns: FloatArray | None,
    shift: FloatArray,
) -> list[Pose]:
    """Head to world at times (T,).

    Parameters
    ----------
    times : (T,) float64, s
    rng : numpy.random.Generator
        Of the small motion of chance.
    turns : (T, 3) float64, optional
        Rotation vectors of a recorded head; chance then moves nothing.
    shift : (T, 3) float64, mm
        Where events move the head.

    Raises
    ------
    ParameterError
        If the keys are not in order of time.
    """
    angles, shifts = sway(times, rng)
    amount = motion.amount if turns is None else 0.0
    keyed_turn, keyed_shift = keyed(motion.keys, times)
    recorded = np.zeros_like(angles) if turns is None else turns
    return [
        Pose(_turned(k, r, amount * a), s)
        for k, r, a, s in zip(
            keyed_turn, recorded, angles, amount * shifts + keyed_shift + shift, strict=True
        )
    ]


def _turned(*parts: FloatArray) -> FloatArray:
    out = np.eye(3)
    for vector in parts:
        out = out @ Pose.from_vectors(vector, np.zeros(3)).rotation
    return out


def keyed(keys: tuple[HeadKey, ...], times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotation vectors, radians, and shifts, mm, (T, 3) each, that keys give."""
    if not keys:
        return np.zeros((len(times), 3)), np.zeros((len(times), 3))
    knots = [key.time for key in keys]
    if any(after <= before for before, after in pairwise(knots)):
        raise ParameterError("the keys of the head's motion are not in order of time", "sort them")
    rows = np.array([[*np.radians(key.turn_degrees), *key.shift] for key in keys])
    if len(keys) == 1:
        rows = np.tile(rows, (len(times), 1))
    else:
        rows = PchipInterpolator(knots, rows)(np.clip(times, knots[0], knots[-1]))
    return np.asarray(rows[:, :3]), np.asarray(rows[:, 3:])


def ramp(times: FloatArray, start: float, end: float, fade: float) -> FloatArray:
    """0 outside of [start, end], 1 inside, with smooth flanks of `fade` seconds inside."""
    fade = min(max(fade, 1e-6), (end - start) / 2)
    share = np.clip(np.minimum(times - start, end - times) / fade, 0, 1)
    return np.asarray(share * share * (3 - 2 * share), np.float64)
