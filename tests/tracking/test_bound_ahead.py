"""Evidence that is bound ahead of the fits is that which would be bound with them."""

from __future__ import annotations

import threading
from functools import cache

import numpy as np
import pytest
import shapes
from drawn import drawn
from runs import write_kind

from abs_engine.io.video import read_frames
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.frame.frame_state import HeadFrame
from abs_engine.tracking.frame.head_frame import HeadBinder
from abs_engine.tracking.frame.landmark_motion import LandmarkMotion
from abs_engine.tracking.loop import track
from abs_engine.tracking.results.frame_journal import FrameJournal, fingerprint
from abs_engine.tracking.run import prepare

AMOUNTS = (0.0, 0.15, 0.3)
pytestmark = pytest.mark.usefixtures("soon_ready")


class OneThread(CpuRenderer):
    """A renderer that only one thread may draw with, as OpenGL's."""

    concurrent = False

    def __init__(self):
        super().__init__()
        self._owner = threading.get_ident()

    def draw(self, *given):
        assert threading.get_ident() == self._owner
        return super().draw(*given)

    def outlines(self, *given):
        assert threading.get_ident() == self._owner
        return super().outlines(*given)

    def measure(self, *given):
        assert threading.get_ident() == self._owner
        return super().measure(*given)


@cache
def images():
    return [drawn("clara", jawOpen=amount) for amount in AMOUNTS]


def prepared(folder, renderer):
    return prepare(write_kind(folder / "clip.mp4", "libx264", images()), renderer)


def followed(setting, image):
    return setting.motion.follower().step(image, None)


@pytest.fixture(scope="module")
def tracker(tmp_path_factory):
    return prepared(tmp_path_factory.mktemp("clip"), CpuRenderer())


def alike(some, others):
    for (_, one), (_, other) in zip(some, others, strict=True):
        assert one.found
        np.testing.assert_array_equal(one.vector, other.vector)
        assert one.aperture == other.aperture


def test_results_are_the_same_with_and_without(tracker, monkeypatch):
    ahead = list(tracker.results())
    monkeypatch.setattr(LandmarkMotion, "alone", False)
    monkeypatch.setattr(HeadBinder, "ahead", lambda *_: pytest.fail("bound ahead"))
    alike(ahead, tracker.results())


def test_a_renderer_of_one_thread_draws_in_that_thread_alone(tracker, tmp_path, monkeypatch):
    """The head is followed ahead all the same, by the CPU rasteriser; what draws is not."""
    usual = list(tracker.results())
    tracked, terms = prepared(tmp_path, OneThread()), HeadBinder._terms

    def drawing(self, *given):
        shapes.draw_one(self.renderer, shapes.ball(0, 0), shapes.view(8)[0])
        return terms(self, *given)

    monkeypatch.setattr(HeadBinder, "_terms", drawing)
    assert tracked.setting.motion.alone
    alike(usual, tracked.results())


def test_without_landmarks_nothing_is_bound_ahead(tracker):
    frame = followed(tracker.setting, images()[0])
    binder = tracker.setting.binder
    assert binder.ahead(frame, frame.pose).keys() == {"colour", "shading"}
    assert binder.ahead(HeadFrame(frame.image, frame.pose), frame.pose) is None


def test_frames_that_are_known_are_not_bound(tracker, tmp_path, monkeypatch):
    mark = fingerprint(tracker.setting)
    with FrameJournal(tmp_path / "frames", mark) as journal:
        first = track(tracker.setting, read_frames(tracker.video), journal=journal)
        for _ in range(2):
            next(first)
        first.close()

    bound, ahead = [], HeadBinder.ahead

    def counted(self, frame, pose):
        bound.append(frame)
        return ahead(self, frame, pose)

    monkeypatch.setattr(HeadBinder, "ahead", counted)
    with FrameJournal(tmp_path / "frames", mark) as journal:
        assert journal.resumed == 2
        assert len(list(tracker.results(journal))) == len(AMOUNTS)
    assert len(bound) == len(AMOUNTS) - 2
