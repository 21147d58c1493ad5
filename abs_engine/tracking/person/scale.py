"""The scale of a result: what its millimetres rest on.

One camera cannot tell a large head far away from a small one near by: shape and pose are found up
to a common factor. What sets it is the distance of the pupils, given or usual.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import ParameterError
from abs_engine.io.assets import Speaker
from abs_engine.tracking.settings.detection import DETECTION
from abs_engine.tracking.settings.head import HEAD_POSE

USUAL_PUPILS, PUPILS_SPREAD = 63.4, 3.8
"""Distance of adults' pupils, mm, and its standard deviation (Dodgson 2004, 3,976 people)."""
_GIVEN = "pupil distance"
_LEAST_PUPILS, _MOST_PUPILS = 30.0, 90.0  # mm; no human's lie outside


@dataclass(frozen=True)
class Scale:
    """Source of the scale in millimetres.

    Parameters
    ----------
    source : str
        "pupil distance" (as given), "usual pupil distance", "known head", "given poses" or
        "average head".
    pupils : float, mm
        Distance of the pupils of the head that is tracked.
    uncertainty : float
        Standard deviation of all lengths in the result, as a share of them, from the scale alone.
    """

    source: str
    pupils: float
    uncertainty: float

    @property
    def held(self) -> float:
        """Standard deviation, mm, of the pupils' distance while a head is fitted."""
        return HEAD_POSE.given_held if self.source == _GIVEN else HEAD_POSE.scale_held

    @property
    def without_eyes(self) -> Scale:
        """The same of a head whose eyes were not seen: pupils say nothing of the rest of it."""
        return replace(self, uncertainty=math.hypot(self.uncertainty, HEAD_POSE.eyes_unseen))


def proportion(vertices: NDArray[np.floating], speaker: Speaker) -> float:
    """Width of a face (V, 3) over its height: the eyes' outer corners, and from there to the lips.

    A picture that was stretched leaves it in a head that is fitted, in part. NaN for a head without
    the usual landmarks.
    """
    if "landmark_68" not in speaker.points:
        return float("nan")
    right, left, lips = vertices[speaker.points["landmark_68"][[36, 45, 51]]].astype(np.float64)
    return float(np.linalg.norm(left - right)) / abs(float((right + left)[1] / 2 - lips[1]))


def pupil_scale(given: float | None) -> Scale:
    """The scale by a pupil distance that was measured, or by the usual one.

    Raises
    ------
    ParameterError
        If it is no distance that people's pupils have.
    """
    if given is None:
        return Scale("usual pupil distance", USUAL_PUPILS, PUPILS_SPREAD / USUAL_PUPILS)
    if not _LEAST_PUPILS <= given <= _MOST_PUPILS:
        raise ParameterError(
            f"{given:g} mm is not a plausible pupil distance",
            f"give millimetres, {_LEAST_PUPILS:g} to {_MOST_PUPILS:g}",
        )
    return Scale(_GIVEN, given, DETECTION.given_spread / given)


def known_scale(pupils: float, person: bool, poses: bool) -> Scale:
    """The scale of a head that is not fitted to landmarks, whose pupils are that far apart, mm."""
    if person:
        return Scale("known head", pupils, 0.0)
    if poses:
        return Scale("given poses", pupils, PUPILS_SPREAD / USUAL_PUPILS)
    spread = math.hypot(USUAL_PUPILS - pupils, PUPILS_SPREAD) / pupils  # about adults' mean
    return Scale("average head", pupils, spread)


def scale_line(told: Mapping[str, Any]) -> str:
    """Line about the source of a run's millimetres, by its `Scale` as a mapping."""
    spread = f", ± {told['uncertainty']:.0%}" if told["uncertainty"] else ""
    return f"scale: {told['source']}, pupils {told['pupils']:.1f} mm apart{spread}"


def pupil_vertices(speaker: Speaker) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Vertices about the right and the left pupil of a head that looks ahead.

    Of a head without eyes, the corners of the eyelids.
    """
    names = speaker.class_names
    painted = speaker.facet_class == (names.index("eyes") if "eyes" in names else -1)
    eyes = np.unique(speaker.faces[painted])
    sides = [eyes[side * speaker.vertices[eyes, 0] > 0] for side in (-1.0, 1.0)]
    if not all(len(side) for side in sides):
        right, left = np.split(np.asarray(speaker.landmarks["eye_corners"], np.intp), 2)
        return right, left
    found = []
    for own in sides:
        front = speaker.vertices[own, 2]
        found.append(own[front >= front.max() - DETECTION.pole * np.ptp(front)])
    return found[0], found[1]


def pupil_distance(speaker: Speaker, vertices: NDArray[np.floating]) -> float:
    """Distance of the pupils of a head (V, 3), in its unit."""
    right, left = (vertices[v].astype(np.float64).mean(axis=0) for v in pupil_vertices(speaker))
    return float(np.linalg.norm(left - right))
