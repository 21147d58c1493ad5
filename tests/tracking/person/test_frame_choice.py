"""The head is fitted to frames in which it faces most differently."""

from __future__ import annotations

import numpy as np
import pytest
from drawn import correspondence, projected, vertices_of
from heads import seen_at

from abs_engine.core.errors import FaceNotFoundError
from abs_engine.core.geometry import rotations
from abs_engine.tracking.detection.landmarks import Landmarks
from abs_engine.tracking.person.frame_choice import candidate_frames, turned_apart
from abs_engine.tracking.settings.preparation import PREPARATION

IMAGE = np.full((4, 4, 3), 100, np.uint8)


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


def numbered(shown):
    """Frames of which some show a face, seen as their numbers."""
    return ((IMAGE, k if there else None) for k, there in enumerate(shown))


def candidates(shown):
    """Numbers of the frames that may be learned from."""
    return [k for _, k in candidate_frames(numbered(shown), "film.mp4")]


@pytest.mark.parametrize("count", [5, 31, 32, 100, 249])
def test_frames_to_choose_from_are_few_and_all_over_the_clip(count):
    found = candidates([True] * count)
    assert found[0] == 0
    assert len(set(np.diff(found))) <= 1
    assert min(count, 2 * PREPARATION.learn_from) <= len(found) < 4 * PREPARATION.learn_from
    assert count - found[-1] <= np.diff([*found, 1 + found[-1]])[0]


def test_what_comes_long_after_the_first_face_is_not_looked_at():
    """Nor does it matter how late that face comes."""
    taken = []

    def film():
        for image, k in numbered([False] * 40 + [True] * 600):
            taken.append(k)
            yield image, k

    found = [k for _, k in candidate_frames(film(), "film.mp4")]
    assert len(taken) == 40 + PREPARATION.look_at
    assert found[0] == 40
    assert found[-1] > 230


@pytest.mark.parametrize(("shown", "enough"), [(11, True), (10, False), (0, False)])
@pytest.mark.parametrize("first", [True, False])
def test_a_few_faces_in_a_clip_of_something_else_are_none(shown, enough, first):
    """Of a hundred frames, more than a tenth must show one, wherever they are."""
    frames = [True] * shown + [False] * (100 - shown)
    frames = frames if first else frames[::-1]
    if enough:
        assert len(candidates(frames)) == shown
        return
    with pytest.raises(FaceNotFoundError, match=f"in {100 - shown} of 100 frames of film.mp4"):
        candidates(frames)
