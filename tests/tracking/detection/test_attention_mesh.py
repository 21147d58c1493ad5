"""The face mesh in two parts: lips are seen where they are, however the square is laid."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from drawn import drawn

from abs_engine.tracking.detection.attention_mesh import SIDE, _Region, _region, seen_mesh
from abs_engine.tracking.detection.landmarks import LIPS

MIDDLE = np.array([159.5, 119.5])
UPPER, LOWER = 13, 14


def looked_at(picture, scale=1.0, turn=0.0, shift=(0.0, 0.0)):
    """Landmarks (468, 2) in the picture, seen in a square that is laid in another way."""
    along = scale * np.array([np.cos(turn), np.sin(turn)])
    matrix = np.column_stack([along, [-along[1], along[0]], MIDDLE + shift])
    matrix[:, 2] -= matrix[:, :2] @ np.full(2, 0.5 * (SIDE - 1))
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    patch = cv2.warpAffine(picture, matrix, (SIDE, SIDE), flags=flags)
    points, presence = seen_mesh(patch)
    assert presence > 0.9
    return points[:, :2] @ matrix[:, :2].T + matrix[:, 2]


@pytest.mark.parametrize(
    "laid", [{"shift": (5.0, -4.0)}, {"turn": 0.15}, {"turn": -0.15}, {"scale": 1.1}]
)
def test_lips_are_seen_alike_however_the_square_is_laid(laid):
    picture = drawn("clara", jawOpen=0.2)
    off = looked_at(picture, **laid)[LIPS] - looked_at(picture)[LIPS]
    assert np.sqrt((off**2).sum(axis=1).mean()) < 1.0  # pixels; the mouth is 40 wide


@pytest.mark.parametrize("person", ["clara", "mei", "ravi", "walter"])
def test_lips_part_as_they_are_drawn(person):
    weights = np.array([0.0, 0.2, 0.4])
    seen = [looked_at(drawn(person, jawOpen=w)) for w in weights]
    opened = np.array([p[LOWER, 1] - p[UPPER, 1] for p in seen])
    assert (np.diff(opened) > 2.0).all()


def test_a_region_is_laid_about_its_landmarks():
    corners = np.array([[40.0, 60], [80, 60], [80, 80], [40, 80]])
    placed = _Region(np.arange(4), (0, 1), 1.5).placed(np.column_stack([corners, np.zeros(4)]))
    np.testing.assert_allclose(placed @ [8, 8, 1], [15, 17.5])  # their middle, in features
    np.testing.assert_allclose(placed @ [16, 8, 1] - placed @ [0, 8, 1], [15, 0])
    np.testing.assert_allclose(placed @ [8, 16, 1] - placed @ [8, 0, 1], [0, 7.5])


def test_the_region_of_the_shipped_network_is_the_lips():
    assert set(LIPS) < set(_region().landmarks)
    assert len(set(_region().landmarks)) == 80
