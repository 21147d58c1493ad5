"""Where in a window the mouth lies, by a pose and posture that is known."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from heads import seen_at
from runs import toy_model, toy_setting

from abs_engine.core.pose import PoseFrame
from abs_engine.core.scene import Candidates
from abs_engine.fit.head_frame import mouth_window
from abs_engine.tracking.frame.mouth_place import mouth_place

SETTING = toy_setting()
MODEL, CAMERA = toy_model(), SETTING.camera
NOBODY = np.zeros(MODEL.n_person)
CLASSES = MODEL.speaker.class_names


@cache
def case(prototype=4, roll=0.0):
    """The place, and which class is drawn there, of the average head in a posture."""
    pose = seen_at([0, 0, roll], [0, 20, 500])
    window = mouth_window(MODEL, pose, CAMERA)
    vector = np.r_[np.zeros(6), MODEL.prototypes[prototype]]
    base = PoseFrame(pose, MODEL.pivot)
    place = mouth_place(MODEL, base, CAMERA, window, NOBODY, vector)
    one = Candidates.one(vector[6:], pose)
    drawn = SETTING.renderer.draw(SETTING.face.scene, one, CAMERA, window)[0].class_id
    return place, drawn, pose, window


def shown(drawn, *names):
    return np.isin(drawn, [CLASSES.index(n) for n in names])


ROLLS = pytest.mark.parametrize("roll", [0.0, 0.5, -0.9, 1.7, 3.1])


@ROLLS
@pytest.mark.parametrize("prototype", [0, 2, 4])
def test_each_lip_lies_on_its_side(prototype, roll):
    place, drawn, _, _ = case(prototype, roll)
    assert place.upper[shown(drawn, "upper_lip")].mean() > 0.85
    assert place.upper[shown(drawn, "lower_lip")].mean() < 0.15
    assert place.upper.min() >= 0
    assert place.upper.max() <= 1


@ROLLS
def test_the_insides_of_lips_and_mouth_are_no_skin_as_far_as_can_be_said(roll):
    place, drawn, _, _ = case(4, roll)
    mouth = shown(drawn, "inner_mouth", "tongue", "upper_teeth", "lower_teeth")
    skin = shown(drawn, "skin")
    assert place.within[mouth].mean() > 0.85
    assert place.beyond[mouth].max() < 0.05
    assert place.beyond[skin].mean() > 0.6
    assert np.percentile(place.within[skin], 98) < 0.1
    assert place.within.max() < 1  # colours that are far likelier still win
    assert place.beyond.max() < 0.97


def test_nothing_is_said_at_the_outline():
    """Within a millimetre of it the colours alone decide."""
    place, _, pose, window = case()
    vertices = MODEL.held(NOBODY).vertices(MODEL.prototypes[4])
    outline = CAMERA.project(pose.apply(vertices[MODEL.rings["outer"]]))
    x, y = np.rint(window.to_drawn(outline)).astype(int).T
    assert place.within[y, x].max() < 0.3
    assert place.beyond[y, x].max() < 0.3


def test_a_mouth_that_moved_has_its_place_moved():
    pose = seen_at([0, 0, 0], [0, 20, 500])
    window, base = mouth_window(MODEL, pose, CAMERA), PoseFrame(pose, MODEL.pivot)
    vector = np.r_[np.zeros(6), MODEL.prototypes[0]]
    lower = vector.copy()
    lower[4] += 6.0  # mm, down in the camera's frame
    one, other = (
        mouth_place(MODEL, base, CAMERA, window, NOBODY, v).within for v in (vector, lower)
    )
    rows = [np.average(np.arange(len(p)), weights=p.sum(axis=1)) for p in (one, other)]
    depth = pose.apply(MODEL.pivot)[2]
    pixels = 6.0 * CAMERA.matrix[0, 0] / depth * window.scale
    assert rows[1] - rows[0] == pytest.approx(pixels, rel=0.15)


def test_a_wider_persons_mouth_has_a_wider_place():
    wide = MODEL.person({"mouth width": 2.0})
    pose = seen_at([0, 0, 0], [0, 20, 500])
    window, base = mouth_window(MODEL, pose, CAMERA), PoseFrame(pose, MODEL.pivot)
    vector = np.r_[np.zeros(6), MODEL.prototypes[0]]
    columns = [
        np.flatnonzero(
            (mouth_place(MODEL, base, CAMERA, window, person, vector).within > 0.5).any(axis=0)
        )
        for person in (NOBODY, wide)
    ]
    assert np.ptp(columns[1]) > np.ptp(columns[0]) + 1
