"""Faces are found where they are, large, small, tilted or cut off; noise and walls are none."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from heads import SIZE, head_of, picture_of, seen_at
from runs import noise

from abs_engine.core.camera import Camera
from abs_engine.io.assets import shipped
from abs_engine.tracking.detection.face_detection import (
    MARKS,
    faces_about,
    faces_beside,
    find_face,
    find_faces,
)
from abs_engine.tracking.detection.initial_pose import face_marks

PEOPLE = ["clara", "kofi", "walter", "mei", "amara", "ravi"]


def off_by(image, model, pose, camera):
    """How far the eyes, the nose and the mouth that are found are from the head's, mm."""
    face = find_face(image)
    assert face is not None
    there = camera.project(pose.apply(face_marks(model)))
    pixel = pose.apply(model.pivot)[2] / camera.matrix[0, 0]
    return np.linalg.norm(face.points[:4] - there, axis=1) * pixel


@pytest.mark.parametrize("person", PEOPLE)
@pytest.mark.parametrize(("place", "size"), [((0, 0, 700), SIZE), ((-60, 30, 900), (640, 480))])
def test_the_face_of_a_bundled_person(person, place, size):
    model, camera = head_of(person), Camera.ideal(size)
    pose = seen_at([0, 0, 0], place)
    assert off_by(picture_of(model.head, pose, camera), model, pose, camera).max() < 8.0


@pytest.mark.parametrize("roll", [-0.5, 0.5])
def test_a_tilted_face(roll):
    model, camera = head_of("clara"), Camera.ideal(SIZE)
    pose = seen_at([0, 0, roll], [0, 0, 700])
    assert off_by(picture_of(model.head, pose, camera), model, pose, camera).max() < 8.0


@pytest.mark.parametrize(
    ("place", "most"), [((30, -20, 420), 8.0), ((60, -30, 500), 8.0), ((25, -45, 420), 12.0)]
)
def test_a_face_that_is_cut_off_by_the_picture(place, most):
    model, camera = head_of("clara"), Camera.ideal(SIZE)
    pose = seen_at([0, 0, 0], place)  # above the brows, an ear, and in the last above the nose
    assert off_by(picture_of(model.head, pose, camera), model, pose, camera).max() < most


@pytest.mark.parametrize("corner", [(0, 0), (860, 0), (300, 470), (861, 470)])
def test_a_small_face_in_a_large_picture(corner):
    model, camera = head_of("walter"), Camera.ideal(SIZE)
    pose = seen_at([0, 0, 0], [0, 0, 700])
    small = cv2.resize(picture_of(model.head, pose, camera), None, fx=0.45, fy=0.45)
    wide = np.full((600, 1020, 3), 90, np.uint8)
    left, top = corner
    height, width = min(small.shape[0], 600 - top), min(small.shape[1], 1020 - left)
    wide[top : top + height, left : left + width] = small[:height, :width]
    found = find_faces(wide)
    assert len(found) == 1
    there = 0.45 * (camera.project(pose.apply(face_marks(model)[3])) + 0.5) - 0.5
    np.testing.assert_allclose(found[0].mouth, there + corner, atol=2.0)


def test_the_largest_of_two_faces():
    camera = Camera.ideal(SIZE)
    near = picture_of(head_of("clara").head, seen_at([0, 0, 0], [0, 0, 700]), camera)
    far = picture_of(head_of("kofi").head, seen_at([0, 0, 0], [0, 0, 1000]), camera)
    both = np.hstack([far, near])
    assert len(find_faces(both)) == 2
    face = find_face(both)
    assert face is not None
    assert SIZE[0] < face.centre[0] < 2 * SIZE[0]
    right, left = (face.points[MARKS.index(name)] for name in ("right_eye", "left_eye"))
    assert right[0] < left[0]  # the subject's right is on the picture's left


def test_a_face_that_is_meant_is_found_beside_a_larger_one():
    camera = Camera.ideal(SIZE)
    near = picture_of(head_of("clara").head, seen_at([0, 0, 0], [0, 0, 500]), camera)
    pose = seen_at([0, 0, 0], [0, 0, 900])
    far = cv2.resize(picture_of(head_of("kofi").head, pose, camera), None, fx=0.3, fy=0.3)
    both = np.full((SIZE[1], SIZE[0] + far.shape[1], 3), 90, np.uint8)
    both[:, : SIZE[0]] = near
    both[60 : 60 + far.shape[0], SIZE[0] :] = far
    small = find_face(far)
    assert small is not None
    place = small.centre + np.array([SIZE[0], 60])
    found = faces_about(both, place, 1.2 * small.size)
    assert np.abs(found[0].centre - place).max() < 3.0
    assert faces_about(both, np.array([SIZE[0] + 20.0, 230.0]), 20.0) == []


def test_small_faces_beside_a_large_one_are_found_in_parts_of_the_picture():
    camera = Camera.ideal(SIZE)
    near = picture_of(head_of("clara").head, seen_at([0, 0, 0], [0, 0, 500]), camera)
    pose = seen_at([0, 0, 0], [0, 0, 700])
    far = cv2.resize(picture_of(head_of("kofi").head, pose, camera), None, fx=0.45, fy=0.45)
    both = np.full((2 * SIZE[1], 3 * SIZE[0], 3), 90, np.uint8)
    both[: SIZE[1], : SIZE[0]] = near
    both[-far.shape[0] :, -far.shape[1] :] = far
    whole = find_faces(both)
    assert len(whole) == 1
    (small,) = faces_beside(both, whole)
    corner = np.array([3 * SIZE[0] - far.shape[1], 2 * SIZE[1] - far.shape[0]])
    there = 0.45 * (camera.project(pose.apply(face_marks(head_of("kofi"))[3])) + 0.5) - 0.5
    np.testing.assert_allclose(small.mouth, there + corner, atol=3.0)
    assert faces_beside(both[: SIZE[1], : SIZE[0]], whole) == []  # a face is none beside itself


def test_faces_come_the_surest_first():
    camera = Camera.ideal(SIZE)
    people = [
        picture_of(head_of(person).head, seen_at(turn, [0, 0, 800]), camera)
        for person, turn in zip(PEOPLE[:4], np.linspace([0, 0, 0], [0, 0.6, 0.3], 4), strict=True)
    ]
    found = find_faces(np.vstack([np.hstack(people[:2]), np.hstack(people[2:])]))
    assert len(found) == 4
    scores = [face.score for face in found]
    assert scores == sorted(scores, reverse=True)


@pytest.mark.parametrize("factor", [2, 4])
def test_places_count_from_the_centres_of_pixels(factor):
    camera = Camera.ideal((640, 480))
    image = picture_of(head_of("walter").head, seen_at([0, 0, 0], [0, 0, 700]), camera)
    small = cv2.resize(image, None, fx=1 / factor, fy=1 / factor, interpolation=cv2.INTER_AREA)
    one, other = find_face(image), find_face(small)
    assert one is not None
    assert other is not None
    enlarged = factor * (other.points + 0.5) - 0.5
    assert np.abs((enlarged - one.points)[:4].mean(axis=0)).max() < 0.7


@pytest.mark.parametrize("seed", range(3))
def test_noise_is_no_face(seed):
    assert find_face(noise(1, (200, 150), seed)[0]) is None


@pytest.mark.parametrize("value", [0, 128, 255])
def test_an_even_picture_is_no_face(value):
    assert find_face(np.full((120, 160, 3), value, np.uint8)) is None


@pytest.mark.parametrize("size", [(1, 1), (3, 500), (500, 3)])
def test_a_sliver_is_no_face(size):
    assert find_face(np.full((*size, 3), 120, np.uint8)) is None


def test_the_network_is_the_one_that_the_provenance_names():
    folder = shipped("detector")
    content = (folder / "face_detection_short_range.tflite").read_bytes()
    assert hashlib.sha256(content).hexdigest() in (folder / "PROVENANCE.md").read_text("utf-8")


def test_another_wheel_is_refused(tmp_path):
    script = Path(__file__).parents[3] / "assets" / "take_detector.py"
    wheel = tmp_path / "other.whl"
    wheel.write_bytes(b"PK")
    done = subprocess.run(
        [sys.executable, str(script), str(wheel), str(tmp_path / "out")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert "pip download mediapipe" in done.stderr
    assert not (tmp_path / "out").exists()
