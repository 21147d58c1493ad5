"""Poses of another head, laid on the one that was fitted."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import FACING, Pose
from abs_engine.tracking.aligned_poses import aligned
from abs_engine.tracking.scale import scale_by_poses

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
            np.testing.assert_allclose(one.translation, other.translation, atol=1e-9)


def test_a_few_frames_tell_of_all_and_one_that_is_off_of_none():
    true = own()
    given = [of_another_head(pose) for pose in true]
    some = [(k, true[k]) for k in (0, 3, 5, 7)]
    far = Pose(some[1][1].rotation, some[1][1].translation + np.array([0, 0, 50.0]))
    found = aligned(given, [some[0], (3, far), *some[2:]], PIVOT)
    away = [one.apply(PIVOT) - other.apply(PIVOT) for one, other in zip(found, true, strict=True)]
    assert np.abs(away).max() < 0.1


def test_poses_that_turn_otherwise_than_the_face_are_refused():
    true, other = own(), own()
    with pytest.raises(ParameterError, match=r"do not turn as the face does.*degrees"):
        aligned(other, list(enumerate(true)), PIVOT)


@pytest.mark.parametrize(("pupils", "fine"), [(29.0, False), (62.0, True), (95.0, False)])
def test_poses_by_which_nobody_is_so_large_are_refused(pupils, fine):
    if fine:
        assert scale_by_poses(pupils).pupils == pupils
        return
    with pytest.raises(ParameterError, match=f"{pupils:.0f} mm apart; give translations in mm"):
        scale_by_poses(pupils)
