"""The seam of the lips: points that a viewer sees, though their exact place lies in a fold.

Lips that touch roll inwards: they overlap by up to a millimetre, and the mesh's line of contact, or
the corner of the mouth, lies behind what is seen of it. A person who marks the points sets
them on the seam that the picture shows. So does this rule.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.io.assets import LIPS_OF_68, Speaker

SLACK = 1.5
"""A point of the lips is seen where its own lip is seen so near to it, mm across the ray."""

DEPTH = 5.0
"""Nothing may be nearer to the camera than such a point by more than this, mm."""

_REACH, _ALONG = 6.0, 2.0
"""Own lip: vertices of its class so near to the point at rest, and so near along the mouth, mm."""

_LIPS = ("upper_lip", "lower_lip")


@lru_cache(maxsize=4)
def lip_strips(speaker: Speaker) -> dict[int, IntArray]:
    """The lip around each of the landmarks 48 to 67: vertices by the landmark's vertex.

    A strip runs from the point over the lip that it belongs to, away from the seam; at the corners
    of the mouth over both lips. Empty for a head without the 68 landmarks.
    """
    if "landmark_68" not in speaker.points:
        return {}
    reds = [speaker.vertices_of(name) for name in _LIPS]
    strips = {}
    for mark in speaker.points["landmark_68"][LIPS_OF_68].tolist():
        own = np.unique(np.concatenate([[mark], *(red for red in reds if mark in red)]))
        away = speaker.vertices[own] - speaker.vertices[mark]
        near = (np.linalg.norm(away, axis=1) < _REACH) & (np.abs(away[:, 0]) < _ALONG)
        strips[mark] = own[near]
    return strips


def beside(points: FloatArray, mark: int, strip: IntArray) -> IntArray:
    """Vertices of a strip within `SLACK` of a landmark, across the ray from the camera to it.

    Parameters
    ----------
    points : (V, 3) float64, mm, camera frame
    strip : (N,) int64
    """
    ray = points[mark] / np.linalg.norm(points[mark])
    away = points[strip] - points[mark]
    across = away - np.outer(away @ ray, ray)
    return np.asarray(strip[np.linalg.norm(across, axis=1) < SLACK], np.int64)
