"""The head is fitted to frames in which it faces most differently."""

from __future__ import annotations

import numpy as np
import pytest
from drawn import correspondence, projected, vertices_of
from heads import seen_at

from abs_engine.core.geometry import rotations
from abs_engine.tracking.frame_choice import turned_apart
from abs_engine.tracking.landmarks import Landmarks


def facing(yaw=0.0, pitch=0.0, roll=0.0, **units):
    """What a network that errs by 0.3 mm would see of a head that faces there, radians."""
    points = correspondence().of(vertices_of(None, **units))
    return projected(points, seen_at([pitch, yaw, roll], [0, 0, 700]), noise=0.3)


@pytest.mark.parametrize("turn", [(0.3, 0, 0), (0, 0.2, 0), (0, 0, 0.25)])
def test_a_turn_between_two_pictures_is_as_large_as_it_is(turn):
    pitch, yaw, roll = turn
    found = facing().turn_to(facing(yaw, pitch, roll))
    assert np.linalg.norm(found) == pytest.approx(max(turn), abs=0.04)
    assert np.argmax(np.abs(found)) == np.argmax(turn)


def test_a_turn_lays_points_on_the_others():
    one, vector = facing(0.2, 0.1), np.array([0.2, -0.3, 0.1])
    turn = rotations(vector[None])[0]
    turned = Landmarks(one.points @ turn.T, 1.0)
    np.testing.assert_allclose(one.turn_to(turned), vector, atol=1e-6)
    mirrored = Landmarks(one.points * [-1, 1, 1], 1.0)
    back = rotations(one.turn_to(mirrored)[None])[0]  # no turn of what is no mirror image
    apart = one.points - one.points.mean(axis=0)
    off = apart @ back.T - apart * [-1, 1, 1]
    assert (off**2).sum() <= (4 * apart[:, 0] ** 2).sum()


def test_a_picture_is_not_turned_to_a_larger_one_elsewhere():
    one = facing(0.2, 0.1)
    moved = Landmarks(1.7 * one.points + [30.0, -20.0, 5.0], 1.0)
    np.testing.assert_allclose(one.turn_to(moved), 0.0, atol=1e-6)


def test_the_frames_that_face_farthest_apart_are_taken():
    """Not those of a head that leans, nor those whose mouth opens."""
    yaws = [0.0, 0.02, 0.5, 0.0, -0.01, -0.5, 0.0, 0.01]
    seen = [facing(yaw) for yaw in yaws]
    seen[3], seen[6] = facing(roll=0.4), facing(jawOpen=0.3)
    seen.append(facing(pitch=0.3))
    assert turned_apart(seen, 4)[1:] == [2, 5, 8]


@pytest.mark.parametrize("count", [1, 3, 5, 9])
def test_each_frame_is_taken_once_and_in_order(count):
    """Even where all are the same picture."""
    picked = turned_apart([facing()] * 5, count)
    assert picked == sorted(set(picked))
    assert len(picked) == min(count, 5)
