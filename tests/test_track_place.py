"""The mouth is found where it is, not where one box or the edge of a window would have it."""

from __future__ import annotations

import numpy as np
import pytest
from heads import SIZE, colours_of, head_of, picture_of, seen_at

from abs_engine.assets import load_speaker
from abs_engine.camera import Camera
from abs_engine.render.cpu import CpuRenderer
from abs_engine.systems.lips import lip_model
from abs_engine.track import place
from abs_engine.track.locate import FaceBox
from abs_engine.track.place import CalibrationFrame, moved, place_mouth, shift_of_boxes

CAMERA = Camera.ideal(SIZE, 500.0)
POSE = seen_at([0.0, 0.0, 0.0], [0.0, 0.0, 600.0])
DEVIATION = np.array([0.06, 0.05, 0.04, 4.0, 5.0, 42.0])


@pytest.fixture(scope="module")
def model():
    return lip_model(load_speaker(), None)


def off(model, frame, wanted):
    """How far the mouth of a frame's pose is from where it is, mm."""
    return frame.pose.apply(model.pivot) - wanted


def test_the_middle_of_several_boxes_places_the_mouth(model, monkeypatch):
    boxes = iter([FaceBox(72, 8, 175), FaceBox(76, 10, 181), FaceBox(70, 20, 60), None])
    monkeypatch.setattr(place, "find_face", lambda _image: next(boxes))
    blank = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
    frames = [CalibrationFrame(blank, POSE)] * 4
    shift = shift_of_boxes(model, frames, CAMERA)
    there = CAMERA.project(moved(frames, shift, model.pivot)[0].pose.apply(model.pivot))
    np.testing.assert_allclose(there, FaceBox(74, 9, 178).mouth, atol=4.0)
    assert not shift[:3].any()


@pytest.mark.parametrize(
    "boxes",
    [
        [None, None, None, FaceBox(100, 60, 120)],
        [FaceBox(10, 10, 30), FaceBox(250, 10, 30), FaceBox(0, 0, 200), None],
    ],
    ids=["hardly any", "of others"],
)
def test_boxes_that_are_few_or_far_off_do_not_count(model, monkeypatch, boxes):
    left = iter(boxes)
    monkeypatch.setattr(place, "find_face", lambda _image: next(left))
    blank = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
    assert not shift_of_boxes(model, [CalibrationFrame(blank, POSE)] * 4, CAMERA).any()


def test_without_any_box_the_poses_stay(model, monkeypatch):
    monkeypatch.setattr(place, "find_face", lambda _image: None)
    blank = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
    assert not shift_of_boxes(model, [CalibrationFrame(blank, POSE)], CAMERA).any()


@pytest.mark.parametrize("wrong", [(6.0, 21.0, 0.0), (-6.0, -21.0, 0.0), (0.0, 15.0, 40.0)])
@pytest.mark.parametrize("person", ["clara", "kofi"])
def test_the_mouth_is_found_by_its_colours(model, person, wrong):
    known = head_of(person)
    image = picture_of(known.head, POSE, CAMERA)
    wanted = POSE.apply(model.pivot)
    shift = np.r_[np.zeros(3), wrong]
    frames = moved([CalibrationFrame(image, POSE)], shift, model.pivot)
    classes = colours_of(known, POSE, CAMERA)
    found = place_mouth(
        model, frames, classes, CAMERA, CpuRenderer(), DEVIATION, np.zeros(model.n_person)
    )
    left = off(model, moved(frames, found, model.pivot)[0], wanted)
    assert abs(left[0]) < 6.0
    assert abs(left[1]) < 8.0


def test_a_mouth_that_is_not_seen_is_neither_grown_nor_hidden(model):
    """On plain skin nothing speaks for another place."""
    classes = colours_of(head_of("clara"), POSE, CAMERA)
    skin = classes.mixtures["skin"].means[0, :2]
    colour = 255 * np.array([*skin, 1 - skin.sum()]) / skin.max() * 0.7
    image = np.full((SIZE[1], SIZE[0], 3), colour).astype(np.uint8)
    found = place_mouth(
        model, [CalibrationFrame(image, POSE)], classes, CAMERA, CpuRenderer(), DEVIATION,
        np.zeros(model.n_person),
    )  # fmt: skip
    assert abs(found[4]) <= 6.0
    assert abs(found[5]) <= 1.2 * DEVIATION[5]
