"""The face is found, its mouth lies where the box says, and noise is no face."""

from __future__ import annotations

import numpy as np
import pytest
from heads import SIZE, head_of, picture_of, seen_at
from runs import noise

from abs_engine.camera import Camera
from abs_engine.track.locate import BOX_WIDTH_MM, MOUTH_WIDTH, FaceBox, find_face, first_pose
from abs_engine.track.place import MOUTH_REACH

DISTORTED = Camera(Camera.ideal((640, 480)).matrix, (640, 480), np.array([-0.2, 0.05]))


@pytest.mark.parametrize("person", ["clara", "kofi", "walter", "mei", "amara", "ravi"])
@pytest.mark.parametrize(("place", "size"), [((0, 0, 700), SIZE), ((-60, 30, 900), (640, 480))])
def test_the_face_of_a_bundled_person(person, place, size):
    model, camera = head_of(person), Camera.ideal(size)
    pose = seen_at([0, 0, 0], place)
    box = find_face(picture_of(model.head, pose, camera))
    assert box is not None
    mouth = camera.project(pose.apply(model.pivot))
    off = np.abs(np.array(box.mouth) - mouth) * BOX_WIDTH_MM / box.size
    assert off[0] < 0.13 * BOX_WIDTH_MM
    assert off[1] < MOUTH_REACH  # so far the tracker looks for it
    found = first_pose(box, camera, model.pivot)
    assert found.translation[2] == pytest.approx(place[2], rel=0.2)


@pytest.mark.parametrize("seed", range(3))
def test_noise_is_no_face(seed):
    assert find_face(noise(1, (200, 150), seed)[0]) is None


@pytest.mark.parametrize("value", [0, 255])
def test_an_even_picture_is_no_face(value):
    assert find_face(np.full((120, 160, 3), value, np.uint8)) is None


def test_the_box_around_a_mouth_comes_back():
    box = FaceBox(40.0, 30.0, 120.0)
    x, y = box.mouth
    width, height = MOUTH_WIDTH * box.size, 20.0
    again = FaceBox.around_mouth(x - width / 2, y - height / 2, width, height)
    np.testing.assert_allclose([again.x, again.y, again.size], [40, 30, 120])


@pytest.mark.parametrize("camera", [Camera.ideal((640, 480)), DISTORTED], ids=["ideal", "lens"])
def test_the_first_pose_puts_the_mouth_where_the_box_expects_it(camera):
    box, mouth = FaceBox(350.0, 60.0, 180.0), np.array([1.0, -45.0, 90.0])
    pose = first_pose(box, camera, mouth)
    np.testing.assert_allclose(camera.project(pose.apply(mouth)), box.mouth, atol=1e-3)
    assert pose.translation[2] > 100
    near = first_pose(FaceBox(350.0, 60.0, 360.0), camera, mouth)
    assert near.apply(mouth)[2] == pytest.approx(pose.apply(mouth)[2] / 2, rel=0.01)
