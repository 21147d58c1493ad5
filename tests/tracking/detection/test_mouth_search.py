"""The mouth is found where it is, not where one box or the edge of a window would have it."""

from __future__ import annotations

import numpy as np
import pytest
from heads import SIZE, colours_of, face_of, head_of, picture_of, seen_at

from abs_engine.core.camera import Camera
from abs_engine.io.assets import load_speaker
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.detection import mouth_search
from abs_engine.tracking.detection.initial_pose import face_marks
from abs_engine.tracking.detection.mouth_search import (
    CalibrationFrame,
    moved,
    shift_of_faces,
    shifted,
)
from abs_engine.tracking.person import calibration_views
from abs_engine.tracking.person.calibration_views import Stand, place_mouth
from abs_engine.tracking.start.blob_start import mouth_model

CAMERA = Camera.ideal(SIZE, 500.0)
POSE = seen_at([0.0, 0.0, 0.0], [0.0, 0.0, 600.0])
DEVIATION = np.array([0.06, 0.05, 0.04, 4.0, 5.0, 42.0])


@pytest.fixture(scope="module")
def model():
    return mouth_model(load_speaker(), None)


def off(model, frame, wanted):
    """How far the mouth of a frame's pose is from where it is, mm."""
    return frame.pose.apply(model.pivot) - wanted


def shift_of(model, monkeypatch, poses):
    """The shift from `POSE` by frames with faces at these poses, or without."""
    marks = face_marks(model)
    left = iter([None if p is None else face_of(marks, p, CAMERA) for p in poses])
    monkeypatch.setattr(mouth_search, "find_face", lambda _image: next(left))
    blank = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
    return shift_of_faces(model, [CalibrationFrame(blank, POSE)] * len(poses), CAMERA)


def test_the_middle_of_several_faces_places_the_head(model, monkeypatch):
    turned = [seen_at([0, 0.2, 0.3], [30, -20, 620]), seen_at([0, 0.24, 0.3], [32, -18, 640])]
    wrong = seen_at([0, 0, -0.4], [-300, 0, 700])  # another person's
    shift = shift_of(model, monkeypatch, [*turned, wrong, None])
    there = shifted(POSE, shift, model.pivot)
    between = seen_at([0, 0.22, 0.3], [31, -19, 630])
    assert there.angle_to(between) < 0.05
    away = there.apply(model.pivot) - between.apply(model.pivot)
    assert np.abs(away).max() < 15.0
    assert np.abs(away[:2]).max() < 4.0


@pytest.mark.parametrize(
    "poses",
    [
        [None, None, None, seen_at([0, 0, 0.2], [20, 0, 600])],
        [seen_at([0, 0, 0], [120, 0, 600]), seen_at([0, 0, 0], [0, 0, 1200]), None, None],
        [None],
    ],
    ids=["hardly any", "of others", "none"],
)
def test_faces_that_are_few_or_far_off_do_not_count(model, monkeypatch, poses):
    assert shift_of(model, monkeypatch, poses) is None


def stand_of(model, frames):
    return Stand(model, frames, CAMERA, CpuRenderer(), np.zeros(6), np.zeros(model.n_person))


@pytest.mark.parametrize(
    ("person", "wrong"),
    [("clara", (6.0, 18.0, 0.0)), ("kofi", (-6.0, -18.0, 0.0)), ("kofi", (0.0, 15.0, 40.0))],
)
def test_the_mouth_is_found_by_its_colours(model, person, wrong):
    known = head_of(person)
    image = picture_of(known.head, POSE, CAMERA)
    wanted = POSE.apply(model.pivot)
    shift = np.r_[np.zeros(3), wrong]
    frames = moved([CalibrationFrame(image, POSE)], shift, model.pivot)
    classes = colours_of(known, POSE, CAMERA)
    found = place_mouth(stand_of(model, frames), classes, DEVIATION)
    left = off(model, moved(frames, found, model.pivot)[0], wanted)
    assert abs(left[0]) < 6.0
    assert abs(left[1]) < 8.0


def test_a_mouth_that_is_not_seen_is_neither_grown_nor_hidden(model):
    """On plain skin nothing speaks for another place."""
    classes = colours_of(head_of("clara"), POSE, CAMERA)
    skin = classes.mixtures["skin"].means[0, :2]
    colour = 255 * np.array([*skin, 1 - skin.sum()]) / skin.max() * 0.7
    image = np.full((SIZE[1], SIZE[0], 3), colour).astype(np.uint8)
    found = place_mouth(stand_of(model, [CalibrationFrame(image, POSE)]), classes, DEVIATION)
    assert abs(found[4]) <= 6.0
    assert abs(found[5]) <= 1.2 * DEVIATION[5]


@pytest.mark.parametrize(("reach", "step"), [(12.0, 3.0), (20.0, 3.0), (0.5, 4.0)])
def test_where_the_mouth_was_told_is_searched_too_and_both_sides_alike(reach, step):
    steps = calibration_views._to_both_sides(reach, step)
    assert 0 in steps
    np.testing.assert_array_equal(steps, -steps[::-1])
    assert reach <= steps.max() < reach + step
