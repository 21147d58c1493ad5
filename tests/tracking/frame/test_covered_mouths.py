"""A mouth that cannot be seen is said to be covered, and gives no numbers."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from heads import colours_of, head_of, picture_of, seen_at
from runs import toy_model, toy_setting

from abs_engine.core.camera import Camera
from abs_engine.tracking.detection.mouth_search import shifted
from abs_engine.tracking.frame.blob_visibility import (
    COVERED,
    OUTSIDE,
    ByBlob,
    MouthEvidence,
)
from abs_engine.tracking.frame.external_poses import GivenMotion
from abs_engine.tracking.frame.frame_state import ShiftedMotion
from abs_engine.tracking.loop import track

CAMERA = Camera.ideal((320, 240))
POSE = seen_at([0, 0, 0], [0, 10, 650])
NOBODY = np.zeros(0)
USUAL = MouthEvidence(0.3, 0.8)


@pytest.mark.parametrize(
    ("area", "posterior", "covered"),
    [
        (0.3, 0.8, False),
        (0.2, 0.7, False),  # lips drawn in
        (0.5, 0.8, False),
        (0.05, 0.8, True),  # a rest beside the hand
        (0.3, 0.1, True),  # clutter
        (1.5, 0.85, True),  # a hand of the lips' colour
        (0.0, 0.0, True),
    ],
)
def test_lips_unlike_the_clips_others_are_covered(area, posterior, covered):
    assert USUAL.covered(MouthEvidence(area, posterior)) == covered


def test_what_is_usual_is_the_median_of_the_frames_that_show_lips():
    seen = [MouthEvidence(0.3, 0.8), None, MouthEvidence(0.0, 0.0), MouthEvidence(0.2, 0.7)]
    assert MouthEvidence.usual([*seen, MouthEvidence(0.25, 0.9)]) == MouthEvidence(0.25, 0.8)
    assert MouthEvidence.usual([None, MouthEvidence(0.0, 0.0)]) is None


@pytest.fixture(scope="module", params=["clara", "kofi", "mei", "ravi"])
def seen(request):
    model = head_of(request.param)
    classes = colours_of(model, POSE, CAMERA)
    return model, classes, picture_of(model.head, POSE, CAMERA)


def hidden_by(picture: np.ndarray, colour: tuple[int, int, int]) -> np.ndarray:
    x, y = (round(float(v)) for v in CAMERA.project(POSE.apply(head_of("clara").pivot)))
    covered = picture.copy()
    cv2.ellipse(covered, (x, y), (48, 34), 0, 0, 360, colour, -1)
    return covered


def test_a_hand_or_a_microphone_before_the_mouth(seen):
    model, classes, picture = seen
    sight = ByBlob(classes, model, CAMERA, NOBODY)
    plain = sight.evidence(picture, POSE)
    usual = MouthEvidence.usual([plain])
    assert usual is not None
    cheek = tuple(int(v) for v in picture[140, 190])
    for colour in (cheek, (30, 30, 34), (200, 200, 205)):
        now = sight.evidence(hidden_by(picture, colour), POSE)
        assert now is not None
        assert usual.covered(now), colour
    moved = seen_at([0, 0.2, 0], [8, 12, 640])
    turned = picture_of(model.head, moved, CAMERA)
    now = sight.evidence(turned, moved)
    assert now is not None
    assert not usual.covered(now)


def test_a_mouth_outside_of_the_picture_has_no_evidence(seen):
    model, classes, picture = seen
    away = seen_at([0, 0, 0], [400, 10, 650])
    assert ByBlob(classes, model, CAMERA, NOBODY).evidence(picture, away) is None


def test_a_covered_frame_holds_nothing_but_the_heads_pose(monkeypatch):
    evidence, asked = iter([MouthEvidence(0.01, 0.0), None]), []

    def look(_self, _image, pose):
        asked.append(pose)
        return next(evidence)

    monkeypatch.setattr(ByBlob, "evidence", look)
    shift, pivot = np.array([0.0, 0.1, 0.0, 1.0, 2.0, 30.0]), toy_model().pivot
    motion = ShiftedMotion(GivenMotion((POSE, POSE)), shift, pivot)
    sight = ByBlob(None, toy_model(), CAMERA, NOBODY, USUAL)
    setting = replace(toy_setting(), motion=motion, visibility=sight)
    image = np.zeros((240, 320, 3), np.uint8)
    results = [r for _, r in track(setting, [image] * 2)]
    assert [r.status for r in results] == [COVERED, OUTSIDE]
    for result in results:
        assert result.covered
        assert not result.found
        wanted = shifted(POSE, shift, pivot)  # as in the frames before it
        np.testing.assert_allclose(result.pose.translation, wanted.translation)
        np.testing.assert_allclose(result.pose.rotation, wanted.rotation)
        assert np.isnan(result.lips).all()
        assert np.isnan(result.aperture)
    for pose in asked:
        np.testing.assert_allclose(pose.translation, shifted(POSE, shift, pivot).translation)
