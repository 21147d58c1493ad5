"""A face that never moves is reported; one that only blinks or speaks for a while is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from drawn import drawn
from heads import seen_at
from runs import lost_result, toy_result, toy_setting

from abs_engine.core.camera import Camera
from abs_engine.tracking.results.still_face import STILL, StillFace
from abs_engine.tracking.runs.recorder import Recorder

NEAR = seen_at([0, 0, 0], [0, 0, 500])
FACE = drawn("clara", NEAR)
CAMERA = Camera.ideal((FACE.shape[1], FACE.shape[0]))
SETTING = replace(toy_setting(), camera=CAMERA, rate=10.0)
FOUND = replace(toy_result(0), pose=NEAR)


def grainy(picture, seed):
    """The picture with noise of 4 levels, in other light."""
    rng = np.random.default_rng(seed)
    light = 1.0 + 0.2 * rng.uniform(-1, 1)
    return np.uint8(np.clip(light * picture + rng.normal(0, 4, picture.shape), 0, 255))


def moved():
    """The face with its mouth, as it lies in the picture, a little lower."""
    x, y = (round(v) for v in CAMERA.project(NEAR.apply(SETTING.face.border)).mean(axis=0))
    out, side = FACE.copy(), round(0.1 * FACE.shape[0])
    out[y : y + side, x - side : x + side] = FACE[
        y - side // 2 : y + side // 2, x - side : x + side
    ]
    return out


def warned(pictures, result=FOUND):
    still = StillFace(SETTING)
    for picture in pictures:
        still.add(picture, result)
    return still.warnings()


def test_a_picture_of_a_face_is_reported_in_noise_and_changing_light():
    assert warned([grainy(FACE, k) for k in range(20)]) == [STILL]


@pytest.mark.parametrize("at", [0, 10, 19])
def test_a_mouth_that_moves_once_is_no_picture(at):
    assert warned([grainy(moved() if k == at else FACE, k) for k in range(20)]) == []


def test_a_short_clip_and_a_lost_face_say_nothing():
    assert warned([FACE] * 19) == []
    assert warned([FACE] * 40, lost_result(0)) == []


def test_the_warning_is_in_the_summary_of_a_run():
    recorder = Recorder(SETTING)
    for k in range(20):
        recorder.add(replace(FOUND, index=k), FACE)
    assert STILL in recorder.record().summary["warnings"]
