"""The choice of a camera that shows most of the lips: section 6.2 asked of trained lips."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.face.shape.lip_dots import lips17
from abs_engine.face.shape.lip_shell import cut_lip_shell
from abs_engine.face.shape.modal import LearnedPhysics
from abs_engine.io.assets import Speaker
from abs_engine.learn.correspondence import shell_points
from abs_engine.learn.reconstruction import CameraGain, rank_cameras
from abs_engine.learn.settings import LEARNING
from abs_engine.learn.training import check_speaker

YAWS = tuple(range(-90, 91, 15))
"""Degrees at which cameras are compared."""


def direction_of(yaw: float, up: float = 0.0) -> FloatArray:
    """Unit vector (3,), head frame, from the head towards a camera, by degrees.

    To the subject's left and upwards; 0 and 0 is frontal. Raises `ParameterError` if one is not
    finite, or the camera would look at the back of the head or along its axis.
    """
    if not (abs(yaw) <= 90 and abs(up) < 90):
        raise ParameterError(
            f"a camera at {yaw:g} degrees, {up:g} up, does not see the lips",
            "give a yaw from -90 to 90 and less than 90 up or down",
        )
    a, b = np.radians([yaw, up])
    return np.array([np.sin(a) * np.cos(b), np.sin(b), np.cos(a) * np.cos(b)])


def yaw_name(yaw: float) -> str:
    """Name of a camera at a yaw in degrees; -0 is 0."""
    return f"{yaw + 0.0:g}"


def rank_yaws(
    physics: LearnedPhysics,
    speaker: Speaker,
    yaws: Iterable[float] = YAWS,
    *,
    have: Iterable[float] = (),
    noise: float | None = None,
) -> list[CameraGain]:
    """Ranking of cameras around a head by what they would reveal of its lips; the best first.

    By the error in mm that is expected to remain, of the posterior covariance (section 6.2). A
    camera sees the 16 dots of the lips that nothing of the head at rest hides from it, and tells
    their two coordinates across its direction.

    Parameters
    ----------
    physics : LearnedPhysics
        As `train` learned it.
    yaws : iterable of float, degrees
        Where cameras may stand: to the subject's left of the face. Each is named by its yaw.
    have : iterable of float, degrees
        Where cameras stand already.
    noise : float, mm, optional
        Standard deviation of a coordinate that a camera tells; by default that of the dots that
        were learned from.

    Raises
    ------
    ModelFormatError
        If the lips were trained on another speaker's head.
    ParameterError
        If no yaw is given, one is beyond the profile, or the noise is below 1e-6 mm or not
        finite.

    Notes
    -----
    What lips do beyond the modes is not part of it, and a hidden dot is hidden in every posture.
    """
    check_speaker(physics, speaker)
    person = physics.person
    head = (speaker.named(person) if person else speaker.vertices).astype(np.float64)
    places, triangles = head[lips17(speaker)[:-1]], head[speaker.faces]
    return rank_cameras(
        physics,
        shell_points(speaker, cut_lip_shell(speaker)),
        {yaw_name(yaw): direction_of(yaw) for yaw in yaws},
        noise=noise,
        have=tuple(direction_of(yaw) for yaw in have),
        seen=lambda towards: np.array([not _hidden(p, towards, triangles) for p in places]),
    )


def camera_results(physics: LearnedPhysics, speaker: Speaker) -> dict[str, Any]:
    """Entries of ``results.json`` on cameras: mm that remain by yaw, alone and beside a frontal.

    `noise_mm`; `without_mm`, the error without a camera; `frontal_mm`, with a frontal one; and
    `yaw`, for each yaw `dots` seen, `alone_mm` and `beside_frontal_mm`.
    """
    alone, beside = rank_yaws(physics, speaker), rank_yaws(physics, speaker, have=(0,))
    added = {gain.name: gain.expected for gain in beside}
    return {
        "noise_mm": physics.noise,
        "without_mm": alone[0].before,
        "frontal_mm": beside[0].before,
        "yaw": {
            gain.name: {
                "dots": gain.points,
                "alone_mm": gain.expected,
                "beside_frontal_mm": added[gain.name],
            }
            for gain in sorted(alone, key=lambda gain: float(gain.name))
        },
    }


def _hidden(place: FloatArray, direction: FloatArray, triangles: FloatArray) -> bool:
    """Whether a ray from a place (3,) meets a triangle of (F, 3, 3) on its way to the camera.

    Moeller and Trumbore (1997).
    """
    corner, one, two = triangles[:, 0], *(triangles[:, k] - triangles[:, 0] for k in (1, 2))
    across = np.cross(direction, two)
    volume = (one * across).sum(axis=1)
    flat = np.abs(volume) < 1e-12
    scale = 1.0 / np.where(flat, 1.0, volume)
    away = place - corner
    u = (away * across).sum(axis=1) * scale
    side = np.cross(away, one)
    v = (side @ direction) * scale
    reach = (side * two).sum(axis=1) * scale
    met = ~flat & (u >= 0) & (v >= 0) & (u + v <= 1) & (reach > LEARNING.hiding)
    return bool(met.any())
