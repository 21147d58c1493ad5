"""Poses of another head, laid on the one that was fitted."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from abs_engine.core.errors import FaceNotFoundError, ParameterError
from abs_engine.core.geometry import FACING, Pose
from abs_engine.tracking.start.aligned_poses import aligned

PIVOT = np.array([1.0, -40.0, 90.0])
TURN = Rotation.from_rotvec([0.1, -0.05, 0.02]).as_matrix()
MOVED = np.array([3.0, -8.0, 12.0])
RANDOM = np.random.default_rng(0)


def own(count=9):
    """Poses of the fitted head that nods and looks aside."""
    turns = Rotation.from_rotvec(0.2 * RANDOM.normal(size=(count, 3))).as_matrix()
    return [Pose(t @ FACING, [5.0 * k, 2.0, 600 + k]) for k, t in enumerate(turns)]


def of_another_head(pose):
    """The same motion in axes that are turned, from an origin that lies elsewhere."""
    return Pose(pose.rotation @ TURN, pose.apply(MOVED))


def test_a_constant_turn_and_shift_of_the_axes_are_undone():
    true = own()
    given = [of_another_head(pose) for pose in true]
    given[4] = None
    found = aligned(given, list(enumerate(true)), PIVOT)
    assert found[4] is None
    for one, other in zip(found, true, strict=True):
        if one is not None:
            np.testing.assert_allclose(one.rotation, other.rotation, atol=1e-9)
            np.testing.assert_allclose(one.translation, other.translation, atol=1e-2)


def test_a_few_frames_tell_of_all_and_one_that_is_off_of_none():
    true = own()
    given = [of_another_head(pose) for pose in true]
    some = [(k, true[k]) for k in (0, 3, 5, 7)]
    far = Pose(some[1][1].rotation, some[1][1].translation + np.array([0, 0, 50.0]))
    found = aligned(given, [some[0], (3, far), *some[2:]], PIVOT)
    away = [one.apply(PIVOT) - other.apply(PIVOT) for one, other in zip(found, true, strict=True)]
    assert np.abs(away).max() < 0.3  # of 50


@pytest.mark.parametrize("off", [[300.0, 0, 0], [0, 0, 300.0], [0, 90.0, 0]])
def test_two_wrong_poses_of_nine_do_not_shrink_all_others(off):
    true = [Pose(own()[k].rotation, [2.0 * k, 1.0, 600 + k]) for k in range(9)]
    given = [of_another_head(pose) for pose in true]
    for wrong in (2, 6):
        given[wrong] = Pose(given[wrong].rotation, given[wrong].translation + np.array(off))
    found = aligned(given, list(enumerate(true)), PIVOT)
    for k in (0, 4, 8):
        np.testing.assert_allclose(found[k].translation, true[k].translation, atol=0.5)


def test_heads_that_turn_far_say_where_an_origin_far_away_lies():
    yaws = [0.0] * 7 + [1.0, -1.0]
    turns = [Rotation.from_euler("y", yaw).as_matrix() @ FACING for yaw in yaws]
    true = [Pose(turn, [2.0 * k, 1.0, 600 + k]) for k, turn in enumerate(turns)]
    given = [Pose(pose.rotation @ TURN, pose.apply(np.array([0.0, 60.0, -80.0]))) for pose in true]
    found = aligned(given, list(enumerate(true)), PIVOT)
    for k in (7, 8):
        np.testing.assert_allclose(found[k].translation, true[k].translation, atol=1.0)


def test_poses_that_turn_otherwise_than_the_face_are_refused():
    true, other = own(), own()
    with pytest.raises(ParameterError, match=r"do not move as the face does.*degrees"):
        aligned(other, list(enumerate(true)), PIVOT)


@pytest.mark.parametrize("unit", [0.1, 0.97, 1.04])
def test_another_unit_of_length_is_undone(unit):
    true = [
        Pose(p.rotation, p.translation + np.array([0, 0, 30.0 * k])) for k, p in enumerate(own())
    ]
    given = [of_another_head(pose) for pose in true]
    given = [Pose(pose.rotation, unit * pose.translation) for pose in given]
    for one, other in zip(aligned(given, list(enumerate(true)), PIVOT), true, strict=True):
        np.testing.assert_allclose(one.apply(PIVOT), other.apply(PIVOT), atol=0.1)


def test_a_head_that_hardly_moves_has_its_origin_where_heads_usually_have_it():
    true = [Pose(FACING, [0.1 * k, 2.0, 600.0]) for k in range(8)]
    given = [Pose(pose.rotation, 1.05 * pose.translation) for pose in true]
    nods = Pose(Rotation.from_rotvec([0.3, 0, 0]).as_matrix() @ FACING, true[0].translation)
    found = aligned(
        [*given, Pose(nods.rotation, 1.05 * nods.translation)], list(enumerate(true)), PIVOT
    )
    np.testing.assert_allclose(found[-1].apply(PIVOT), nods.apply(PIVOT), atol=1.5)


def test_poses_that_go_elsewhere_than_the_face_are_refused():
    true = own()
    given = [Pose(pose.rotation, pose.translation[[2, 0, 1]] + 500) for pose in own()]
    given = [Pose(a.rotation, b.translation) for a, b in zip(true, given, strict=True)]
    given = [Pose(p.rotation, p.translation + 200 * RANDOM.normal(size=3)) for p in given]
    with pytest.raises(ParameterError, match="do not move as the face does"):
        aligned(given, list(enumerate(true)), PIVOT)


def test_no_frame_with_both_is_no_face():
    with pytest.raises(FaceNotFoundError, match="a pose and a face"):
        aligned([None] * 3, list(enumerate(own(3))), PIVOT)
