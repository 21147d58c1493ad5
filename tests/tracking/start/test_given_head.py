"""Given poses of a clip's head, before it is known who it is."""

from __future__ import annotations

import numpy as np
import pytest
from drawn import CAMERA, drawn, speaker
from heads import seen_at

from abs_engine.core.geometry import Pose
from abs_engine.tracking.detection.face_choice import LARGEST
from abs_engine.tracking.start.given_head import GivenHead

BETWEEN_EYES, CROWN = (0.0, 70.0, 80.0), (0.0, 120.0, 0.0)


@pytest.mark.parametrize("origin", [BETWEEN_EYES, CROWN])
def test_poses_from_another_origin_are_of_the_face_that_is_there(origin):
    true = seen_at([0, 0, 0], [10, -5, 700])
    pose = Pose(true.rotation, true.apply(np.array(origin)))
    choice = GivenHead((pose,), pose, CAMERA).choice(speaker())
    assert choice.first(drawn("clara", true))[0] is not None


def test_without_a_pose_in_the_first_frame_they_are_of_the_largest_face():
    assert GivenHead((None,), None, CAMERA).choice(speaker()) == LARGEST
