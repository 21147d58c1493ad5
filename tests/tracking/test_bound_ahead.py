"""Evidence that is bound ahead of the fits is that which would be bound with them."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from drawn import drawn
from runs import write_kind

from abs_engine.io.video import read_frames
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.frame_journal import FrameJournal, fingerprint
from abs_engine.tracking.frame_state import HeadFrame
from abs_engine.tracking.head_frame import HeadBinder
from abs_engine.tracking.loop import track
from abs_engine.tracking.run import prepare

AMOUNTS = (0.0, 0.15, 0.3, 0.1, 0.0)


class OneThread(CpuRenderer):
    """A renderer that only one thread may draw with, as OpenGL's."""

    concurrent = False


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


def test_results_are_the_same_with_and_without(tracker, tmp_path):
    alone = prepared(tmp_path, OneThread())
    for (_, ahead), (_, with_it) in zip(tracker.results(), alone.results(), strict=True):
        assert ahead.found
        np.testing.assert_array_equal(ahead.vector, with_it.vector)
        assert ahead.aperture == with_it.aperture


def test_without_landmarks_nothing_is_bound_ahead(tracker):
    frame = followed(tracker.setting, images()[0])
    binder = tracker.setting.binder
    assert binder.ahead(frame, frame.pose).keys() == {"colour"}
    assert binder.ahead(HeadFrame(frame.image, frame.pose), frame.pose) is None


def test_frames_that_are_known_are_not_bound(tracker, tmp_path, monkeypatch):
    mark = fingerprint((tracker.setting, tracker.memory))
    with FrameJournal(tmp_path / "frames", mark) as journal:
        first = track(tracker.setting, read_frames(tracker.video), tracker.memory, journal)
        for _ in range(3):
            next(first)
        first.close()

    bound, ahead = [], HeadBinder.ahead

    def counted(self, frame, pose):
        bound.append(frame)
        return ahead(self, frame, pose)

    monkeypatch.setattr(HeadBinder, "ahead", counted)
    with FrameJournal(tmp_path / "frames", mark) as journal:
        assert journal.resumed == 3
        assert len(list(tracker.results(journal))) == len(AMOUNTS)
    assert len(bound) == len(AMOUNTS) - 3
