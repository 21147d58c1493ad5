"""A face is followed while other things are loaded: as it would be later, until it is asked for."""

from __future__ import annotations

import itertools
import time
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from drawn import drawn
from heads import SIZE, seen_at
from runs import write_kind

from abs_engine.cli import main
from abs_engine.core import threads
from abs_engine.core.errors import FaceNotFoundError
from abs_engine.io.video import read_frames
from abs_engine.tracking.detection import first_look as looks
from abs_engine.tracking.detection.face_choice import LARGEST, FaceChoice, FaceFollower
from abs_engine.tracking.detection.first_look import first_look, follower_of
from abs_engine.tracking.models import heads
from abs_engine.tracking.settings.preparation import PREPARATION

BLANK = np.full((SIZE[1], 2 * SIZE[0], 3), 100, np.uint8)


@cache
def pictures():
    """Nobody, then two people who move, then both on the other side, after a cut."""
    near = [drawn("clara", seen_at([0, 0, 0], [x, 0, 700])) for x in (-8, 0, 8)]
    far = drawn("kofi", seen_at([0, 0, 0], [0, 0, 900]))
    pairs = [np.hstack([far, one]) for one in near]
    return [BLANK, *pairs, np.ascontiguousarray(pairs[-1][:, ::-1])]


@pytest.fixture(scope="module")
def video(tmp_path_factory):
    return write_kind(tmp_path_factory.mktemp("film") / "two.mkv", "ffv1", list(pictures()))


def until(true):
    """Wait until something is true."""
    end = time.monotonic() + 60
    while not true():
        assert time.monotonic() < end
        time.sleep(0.01)


def followed(video, follower):
    """Landmarks in all frames, and the remarks."""
    seen = [follower.step(image) for image in read_frames(video)]
    return [None if one is None else one.pixels for one in seen], follower.remarks()


@pytest.mark.parametrize("least", [0, 2, 5])
@pytest.mark.parametrize("choice", [LARGEST, FaceChoice(2)])
def test_a_face_is_found_as_without_a_first_look(video, choice, least, monkeypatch):
    expected, said = followed(video, FaceFollower(choice))
    with first_look(video, choice):
        early = looks._begun[0]._follower
        until(lambda: len(early.found) >= least)
        follower = follower_of(video, choice)
        again = len(early.found)
        steps, step = [], FaceFollower._next
        monkeypatch.setattr(
            FaceFollower, "_next", lambda self, image: steps.append(1) or step(self, image)
        )
        found, lines = followed(video, follower)
    assert len(steps) == len(expected) - again <= len(expected) - least
    assert lines == said
    assert "2 faces: " in said
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(one, other)


def test_another_video_or_face_is_looked_at_afresh(video, tmp_path):
    with first_look(video, LARGEST):
        until(lambda: len(looks._begun[0]._follower.found) >= 1)
        for other in (follower_of(video, FaceChoice(1)), follower_of(tmp_path / "v.mp4", LARGEST)):
            assert other._known == ()
    assert follower_of(video, LARGEST)._known == ()


def test_a_first_look_ends_with_what_it_was_for(video, monkeypatch):
    images, read = pictures(), []

    def endless(_path):
        for k in itertools.count():
            read.append(k)
            yield images[1]

    monkeypatch.setattr(looks, "read_frames", endless)
    with first_look(video, LARGEST):
        until(lambda: len(read) > 2)
    count = len(read)
    assert looks._begun == []
    time.sleep(0.2)
    assert len(read) <= count + 1


def test_a_first_look_is_no_longer_than_what_is_learned_from(video, monkeypatch):
    monkeypatch.setattr(looks, "read_frames", lambda _path: itertools.repeat(pictures()[0]))
    monkeypatch.setattr(looks, "PREPARATION", replace(PREPARATION, look_at=6))
    with first_look(video, LARGEST):
        early = looks._begun[0]
        until(lambda: len(early._follower.found) == 6)
        until(lambda: not early._busy.locked())
        assert len(early._follower.found) == 6


def test_what_is_wrong_is_left_to_whoever_follows_next(video):
    """There is no ninth face: that is found out in the second frame, as the first is blank."""
    with first_look(video, FaceChoice(9)):
        early = looks._begun[0]
        until(lambda: len(early._follower.found) == 1)
        follower = follower_of(video, FaceChoice(9))
        assert follower._known == (None,)
        with pytest.raises(FaceNotFoundError, match="there is no face 9"):
            followed(video, follower)


def test_on_one_core_nothing_is_looked_at_early(video, monkeypatch):
    monkeypatch.setattr(threads, "_alone", True)
    with first_look(video, LARGEST):
        assert follower_of(video, LARGEST)._known == ()


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """The two people, without a cut."""
    return write_kind(tmp_path_factory.mktemp("short") / "two.mkv", "ffv1", list(pictures()[1:3]))


@pytest.mark.usefixtures("soon_ready")
@pytest.mark.parametrize(
    ("more", "early"),
    [((), 1), (("--face", "2"), 1), (("--start", "blobs"), 0), (("--person", "clara"), 0)],
)
def test_the_command_looks_early_where_landmarks_place_the_face(
    short, more, early, monkeypatch, tmp_path
):
    begun, found = [], []
    begin, follower = looks.begin, heads.follower_of
    monkeypatch.setattr(looks, "begin", lambda what: begun.append(what) or begin(what))
    monkeypatch.setattr(
        heads, "follower_of", lambda *given: found.append(looks._begun[:]) or follower(*given)
    )
    words = ["track", str(short), "-o", str(tmp_path / "run"), "--renderer", "cpu", "--quiet"]
    assert main([*words, *more]) == 0
    assert len(begun) == early
    assert [len(one) for one in found] == [1] * early
