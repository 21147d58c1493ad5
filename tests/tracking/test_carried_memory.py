"""State that is carried from frame to frame, over cuts and uneven times."""

from __future__ import annotations

from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest
from runs import lost_result
from talkers import CAMERA, RENDERER, learned_face
from talkers import POSE as BEFORE

from abs_engine.core.clock import Clock
from abs_engine.core.geometry import FACING, Pose
from abs_engine.face.talking import as_face
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking import loop
from abs_engine.tracking.frame import landmark_motion
from abs_engine.tracking.frame.clip_setting import ClipSetting
from abs_engine.tracking.frame.frame_state import HeadFrame, Memory
from abs_engine.tracking.loop import track
from abs_engine.tracking.models.talking_faces import FaceBinder

POSE = Pose(FACING, [0.0, 0.0, 700.0])
IMAGE = np.zeros((4, 4, 3), np.uint8)


class Follower:
    """A head that stays where it is, in shots of two frames."""

    gaps: ClassVar[list[float]] = []
    """Since the frame before, in frames, as they were given."""

    def __init__(self) -> None:
        self._count = 0

    def step(self, image, memory):
        """The next frame."""
        self._count += 1
        self.gaps.append(memory.gap)
        return HeadFrame(image, POSE, cut=self._count == 3)

    def finish(self):
        """Any number will do."""


def carried(monkeypatch, times, rate=25.0, alone=False):
    """The memory that each of four frames is fitted with; the head may be followed `alone`."""
    seen = []

    def step(_setting, index, _frame, _hidden, memory):
        seen.append(memory)
        return lost_result(index), Memory(np.full(8, float(index)), POSE, np.zeros(8))

    monkeypatch.setattr(loop, "_step", step)
    motion = SimpleNamespace(follower=Follower, alone=alone)
    setting = ClipSetting(None, None, CpuRenderer(), rate, motion, None, times=times, clock=Clock())
    assert len(list(track(setting, [IMAGE] * 4))) == 4
    return seen


def test_nothing_of_the_mouth_is_carried_over_a_cut(monkeypatch):
    seen = carried(monkeypatch, ())
    assert [memory.vector is None for memory in seen] == [True, False, True, False]


def test_a_mouth_may_move_farther_where_time_has_passed(monkeypatch):
    gaps = [memory.gap for memory in carried(monkeypatch, (0.0, 0.04, 1.04, 1.08))]
    assert gaps == [1.0, pytest.approx(1.0), pytest.approx(25.0), pytest.approx(1.0)]
    assert {memory.gap for memory in carried(monkeypatch, (0.0, 0.04, 0.08, 0.12))} == {1.0}


@pytest.mark.parametrize("alone", [False, True])
def test_a_head_is_followed_with_the_time_that_has_passed(monkeypatch, alone):
    monkeypatch.setattr(Follower, "gaps", [])
    carried(monkeypatch, (0.0, 0.04, 1.04, 1.08), alone=alone)
    assert Follower.gaps == pytest.approx([1.0, 1.0, 25.0, 1.0])


def test_a_head_may_turn_farther_where_time_has_passed(monkeypatch):
    """A camera at 50 frames a second, of which ten were dropped."""
    asked = []
    monkeypatch.setattr(landmark_motion, "placed_fit", lambda *given: asked.append(given[-1]))
    monkeypatch.setattr(landmark_motion, "FaceFollower", lambda *_: SeesAFace())
    follower = landmark_motion.LandmarkMotion(None, None, rate=50.0).follower()
    for gap in (1.0, 11.0):
        follower.step(IMAGE, Memory(gap=gap))
    follower.step(IMAGE)
    assert asked == pytest.approx([0.02, 0.22, 0.02])


class SeesAFace:
    """A follower of faces that sees the same one in each frame."""

    cut = False

    def step(self, _image):
        """What is seen of it."""
        return ()


def test_so_may_that_of_a_face_that_talks():
    face = as_face(learned_face())
    binder = FaceBinder(face, CAMERA, RENDERER, 25.0, {}, ())
    frame, count = HeadFrame(np.zeros((64, 64, 3), np.uint8), BEFORE), len(face.posture)
    steps = []
    for gap in (1.0, 4.0):
        memory = Memory(np.zeros(6 + count), BEFORE, gap=gap)
        steps.append(binder.work(frame, BEFORE, memory).problem.priors[-1].deviation)
    np.testing.assert_allclose(steps[1][6:], 2 * steps[0][6:])
    np.testing.assert_array_equal(steps[1][:6], steps[0][:6])
