"""The first pose of the head: by a face that was found, or by a box around the mouth."""

from __future__ import annotations

import numpy as np
import pytest
from heads import SIZE, face_of, head_of, picture_of, seen_at

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose, rotations
from abs_engine.io.assets import load_speaker
from abs_engine.tracking.detection.face_detection import Face, find_face
from abs_engine.tracking.detection.initial_pose import (
    FaceBox,
    face_marks,
    first_pose,
    pose_of_face,
    with_mouth_at,
)
from abs_engine.tracking.settings.detection import DETECTION
from abs_engine.tracking.start.blob_start import mouth_model

DISTORTED = Camera(Camera.ideal((640, 480)).matrix, (640, 480), np.array([-0.2, 0.05]))
CAMERAS = pytest.mark.parametrize(
    "camera", [Camera.ideal((640, 480)), DISTORTED], ids=["ideal", "lens"]
)


@CAMERAS
@pytest.mark.parametrize(
    ("turn", "lean"), [((0, 0, 0), 0), ((0, 0.3, 0), 0), ((0, 0.3, 0), 0.8), ((0, -0.3, 0), -1.2)]
)
def test_the_pose_of_a_face(camera, turn, lean):
    model = head_of("ravi")
    upright = seen_at(turn, [20, -15, 800])
    leaning = rotations(np.array([[0, 0, lean]]))[0]
    marks, pose = face_marks(model), Pose(leaning @ upright.rotation, upright.translation)
    found = pose_of_face(face_of(marks, pose, camera), camera, marks)
    assert found.angle_to(pose) < 0.04
    away = found.apply(marks[3]) - pose.apply(marks[3])
    assert np.abs(away[:2]).max() < 1.5
    assert abs(away[2]) < 20
    np.testing.assert_allclose(
        camera.project(found.apply(marks[3])), camera.project(pose.apply(marks[3])), atol=1e-3
    )


def test_nodding_is_taken_for_less_than_it_is():
    marks, camera = face_marks(head_of("ravi")), Camera.ideal((640, 480))
    pose = seen_at([0.1, 0, 0], [0, 0, 800])
    found = pose_of_face(face_of(marks, pose, camera), camera, marks)
    assert 0.02 < found.angle_to(pose) < 0.1


def test_points_beyond_the_reach_of_a_lens_model_are_taken_as_without_it():
    matrix = np.array([[400.0, 0, 320], [0, 400, 240], [0, 0, 1]])
    camera = Camera(matrix, (640, 480), np.array([-0.35]))
    marks = face_marks(head_of("ravi"))
    points = np.zeros((6, 2))
    points[:4] = [[-300, -200], [-100, -200], [-200, -60], [-200, 40]]
    found = pose_of_face(Face(points[:4].mean(axis=0), 300.0, points, 1.0), camera, marks)
    right, left = found.apply(marks[:2])[:, :2]
    assert right[0] < left[0] < 0


def test_an_unlikely_face_is_not_taken_for_a_nod():
    marks = face_marks(head_of("ravi"))
    long = marks + np.array([[0, 0, 0], [0, 0, 0], [0, -5, 0], [0, -9, 0]])
    camera, pose = Camera.ideal((640, 480)), seen_at([0, 0, 0], [0, 0, 700])
    found = pose_of_face(face_of(long, pose, camera), camera, marks)
    assert found.angle_to(pose) < 0.1
    assert found.translation[2] == pytest.approx(700, rel=0.04)  # the eyes tell it


@pytest.mark.parametrize("person", ["clara", "kofi", "walter", "mei", "amara", "ravi"])
@pytest.mark.parametrize("turn", [(0, 0, 0), (0, 0.25, 0.2)])
def test_the_pose_of_a_head_in_a_picture(person, turn):
    model, camera = head_of(person), Camera.ideal(SIZE)
    pose = seen_at(turn, [10, 5, 700])
    face = find_face(picture_of(model.head, pose, camera))
    assert face is not None
    found = pose_of_face(face, camera, face_marks(model))
    assert found.angle_to(pose) < 0.16  # noses are vague in pictures without shading
    away = found.apply(model.pivot) - pose.apply(model.pivot)
    assert np.abs(away[:2]).max() < 7.0
    assert abs(away[2]) < 45.0


def test_the_eyes_of_somebody_are_as_far_apart_as_people_s():
    somebody, known = mouth_model(load_speaker(), None), head_of("mei")
    assert np.ptp(face_marks(somebody)[:2, 0]) == pytest.approx(DETECTION.eyes_apart)
    eyes = known.head.mean[known.speaker.landmarks["eye_corners"], 0]
    assert np.ptp(face_marks(known)[:2, 0]) == pytest.approx(eyes[2:].mean() - eyes[:2].mean())


def test_the_box_around_a_mouth_comes_back():
    box = FaceBox(40.0, 30.0, 120.0)
    x, y = box.mouth
    width, height = DETECTION.mouth_width * box.size, 20.0
    again = FaceBox.around_mouth(x - width / 2, y - height / 2, width, height)
    np.testing.assert_allclose([again.x, again.y, again.size], [40, 30, 120])


def test_a_box_shows_which_face_is_meant():
    one, two = (
        Face(np.array([x, 100.0]), 90.0, np.tile([x, 130.0], (6, 1)), score)
        for x, score in ((100.0, 0.7), (300.0, 0.9))
    )
    box = FaceBox.around_mouth(82.0, 125.0, 40.0, 16.0)  # its middle is at (102, 133)
    assert box.shown([two, one]) is one
    assert box.shown([two]) is None
    assert box.shown([]) is None
    beside = Face(one.centre, 90.0, np.tile([110.0, 128.0], (6, 1)), 0.95)
    assert box.shown([beside, one]) is one


@CAMERAS
def test_a_head_is_moved_until_its_mouth_is_seen_there(camera):
    pose, mouth = seen_at([0, 0.2, 0.4], [30, 20, 700]), np.array([1.0, -45.0, 90.0])
    moved = with_mouth_at(pose, np.array([200.0, 150.0]), camera, mouth)
    np.testing.assert_allclose(camera.project(moved.apply(mouth)), [200, 150], atol=1e-3)
    np.testing.assert_array_equal(moved.rotation, pose.rotation)
    assert moved.apply(mouth)[2] == pytest.approx(pose.apply(mouth)[2])


@CAMERAS
def test_the_first_pose_puts_the_mouth_where_the_box_expects_it(camera):
    box, mouth = FaceBox(350.0, 60.0, 180.0), np.array([1.0, -45.0, 90.0])
    pose = first_pose(box, camera, mouth)
    np.testing.assert_allclose(camera.project(pose.apply(mouth)), box.mouth, atol=1e-3)
    assert pose.translation[2] > 100
    near = first_pose(FaceBox(350.0, 60.0, 360.0), camera, mouth)
    assert near.apply(mouth)[2] == pytest.approx(pose.apply(mouth)[2] / 2, rel=0.01)
