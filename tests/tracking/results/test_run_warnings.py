"""What a user is told of a run that is to be doubted, and that a sound one is not."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from runs import lost_result

from abs_engine.tracking.frame.clip_setting import GREY
from abs_engine.tracking.results.mouth_check import mouth_otherwise
from abs_engine.tracking.results.run_warnings import (
    all_closed,
    close_up,
    disagreement,
    doubts,
    little_explained,
    mostly_lost,
    other_head,
    small_mouth,
    unlike_shots,
    untimed,
    without_colour,
)
from abs_engine.tracking.run import remark_lines
from abs_engine.tracking.settings.doubts import DOUBTS

GOOD = {"upper_lip": 0.95, "lower_lip": 0.9}
TALK = 6 + 5 * np.sin(np.arange(40) / 3)
NONE = np.zeros(40, bool)
SURE = np.full(40, 0.5)


def contradicted(aperture, deviation, by_landmarks):
    """Mask (T,) of the frames in which landmarks contradict an aperture."""
    rows = zip(aperture, deviation, by_landmarks, strict=True)
    results = [replace(lost_result(0), disagreement=disagreement(*row)) for row in rows]
    return np.array([result.contradicted for result in results])


def test_measures_disagree_less_the_less_is_known():
    """In a wide mouth landmarks are less sure, and so is an aperture without a deviation."""
    near, wide = disagreement(4.0, 0.5, 2.0), disagreement(14.0, 0.5, 12.0)
    assert near > wide > 0
    assert disagreement(2.0, 0.5, 4.0) < near  # 4 mm by the landmarks
    assert disagreement(4.0, np.nan, 2.0) < disagreement(4.0, 0.1, 2.0)


@pytest.mark.parametrize(
    ("size", "warned"),
    [((640, 480), False), ((640, 160), True), ((288, 512), False), ((200, 512), True)],
)
def test_a_face_that_is_larger_than_the_picture_is_a_close_up(size, warned):
    """Of 0.5 mm a pixel, a face is 400 pixels high and 288 wide: a portrait holds it."""
    assert bool(close_up(0.5, size)) == warned
    assert not close_up(np.nan, size)
    assert not close_up(2.0, size)


@pytest.mark.parametrize(("seen", "told"), [(4, 0), (5, 1), (10, 1)])
def test_mouths_elsewhere_are_told_where_half_the_frames_show_a_face(seen, told):
    assert len(mouth_otherwise(seen, 0, seen, 10)) == told


def test_a_sound_run_has_no_doubts():
    noise = np.random.default_rng(0).normal(0, 0.7, 40)
    against = contradicted(TALK + noise, SURE, TALK)
    assert doubts(against, NONE, GOOD) == []


def test_lips_of_the_skins_colour_are_told_each():
    (line,) = doubts(NONE, NONE, {"upper_lip": 0.61, "lower_lip": 0.72})
    assert "nearly the same colour" in line
    assert "upper lip 61%, lower lip 72%" in line


def test_lips_that_nothing_shows_may_be_hidden_all_the_time():
    (line,) = doubts(NONE, NONE, {"upper_lip": 0.49, "lower_lip": 0.61})
    assert "if a mask or a hand hides the mouth throughout" in line
    assert "upper lip 49%, lower lip 61%" in line


@pytest.mark.parametrize(("told", "lines"), [(-0.01, 1), (0.01, 0)])
def test_where_they_begin_to_be_the_same(told, lines):
    both = dict.fromkeys(GOOD, DOUBTS.least_separability + told)
    assert len(doubts(NONE, NONE, both)) == lines


@pytest.mark.parametrize(("told", "lines"), [(-0.01, 1), (0.01, 0)])
def test_colours_that_open_the_mouth_less_than_landmarks(told, lines):
    found = doubts(NONE, NONE, GOOD, DOUBTS.least_agreement + told)
    assert len(found) == lines
    assert all("opens 69% as far as by landmarks" in line for line in found)


def test_a_mouth_of_some_pixels_is_blamed_in_the_place_of_its_colours():
    (line,) = small_mouth(6.2)
    assert line.startswith("the mouth is only 6.2 pixels wide")
    assert small_mouth(DOUBTS.least_mouth) == small_mouth(float("nan")) == []
    assert doubts(NONE, NONE, GOOD, 0.06, small=True) == []


def test_colours_that_open_it_the_wrong_way_open_it_by_nothing():
    (line,) = doubts(NONE, NONE, GOOD, -0.4)
    assert "opens 0% as far" in line


def test_separability_that_was_not_measured_is_no_doubt():
    assert doubts(NONE, NONE, {}) == []


def test_a_mouth_that_is_closed_where_landmarks_open_it():
    shut = np.where(TALK > 8, 0.0, TALK)
    against = contradicted(shut, SURE, TALK)
    np.testing.assert_array_equal(against, TALK > 8)
    (line,) = doubts(against, NONE, GOOD)
    assert line.startswith(f"in {against.mean():.0%} of the frames the mouth is open farther")
    assert "overlay" in line


def test_the_same_difference_counts_less_where_the_fit_is_unsure():
    assert contradicted(TALK + 4, SURE, TALK).any()
    assert not contradicted(TALK + 4, 10 * SURE, TALK).any()


def test_lost_frames_contradict_nothing():
    lost = np.where(np.arange(40) % 2 == 0, np.nan, TALK + 9)
    against = contradicted(lost, np.full(40, np.nan), TALK)
    assert not against[::2].any()
    assert against[1::2].all()
    assert doubts(against[:9], NONE[:9], GOOD) == []  # too few to say


def test_frames_that_were_held_to_the_landmarks():
    held = np.arange(40) < 10
    (line,) = doubts(NONE, held, GOOD)
    assert line.startswith("in 25% of the frames what is drawn led off the lips")
    assert doubts(NONE, [k < 4 for k in range(40)], GOOD) == []


@pytest.mark.parametrize(("source", "limit", "said"), [
    ("colour", DOUBTS.least_score, "the drawn mouth explains only 77%"),
    ("texture", DOUBTS.least_face_score, "is it this speaker's"),
    ("local", DOUBTS.least_face_score, "the face explains only 79%"),
    ("talking: local", DOUBTS.least_talking_score, "the talking face explains only 69%"),
    ("talking: texture", DOUBTS.least_talking_score, "track without --model"),
    ("talking: colour", DOUBTS.least_score, "the drawn mouth explains only 77%"),
])  # fmt: skip
def test_a_run_that_explains_little(source, limit, said):
    (line,) = little_explained(source, limit - 0.01)
    assert said in line
    assert little_explained(source, limit + 0.01) == []


def test_what_is_not_known_to_explain_little():
    assert little_explained("colour", None) == little_explained("plugin: own", 0.1) == []


def test_lips_that_never_open_are_doubted_where_the_clip_is_longer_than_a_pause():
    time = np.arange(75) / 25
    shut = np.ones(75, bool)
    (line,) = all_closed(shut, time)
    assert line.startswith("the lips are closed in all 75 frames that were tracked")
    assert "overlay" in line
    assert all_closed(shut[:60], time[:60]) == all_closed(shut[:0], time[:0]) == []
    assert all_closed(np.arange(75) > 0, time) == []


def test_most_frames_lost():
    found = np.arange(10) > 5
    status = np.where(found, "converged", "mouth covered")
    (line,) = mostly_lost(found, status)
    assert line.startswith("only 4 of 10 frames were tracked (mouth covered in 6)")
    assert mostly_lost(~found, status) == mostly_lost(found[:0], status[:0]) == []


def test_frames_that_lose_their_colour_are_counted():
    status = np.array(["", GREY, "mouth covered", GREY])
    (line,) = without_colour(status)
    assert line.startswith("2 of 4 frames have no colour")
    assert without_colour(status[[0, 2]]) == []


def test_the_head_of_another_person():
    (line,) = other_head(DOUBTS.most_speaker_misfit + 0.1)
    assert "landmarks lie 1.6 standard deviations off, its own speaker's less than 1.5" in line
    assert other_head(DOUBTS.most_speaker_misfit) == ()


def test_all_of_it_at_once_and_nothing_at_all():
    bad = dict.fromkeys(GOOD, 0.55)
    assert len(doubts(~NONE, [True] * 40, bad)) == 3
    assert doubts(NONE[:0], [], {}) == []


def test_remarks_that_are_warnings_are_printed_as_such():
    setting = SimpleNamespace(warnings=("the head is another's", "of the setting alone"))
    tracker = SimpleNamespace(setting=setting, remarks="2 faces\nthe head is another's")
    assert remark_lines(tracker) == "2 faces\nwarning: the head is another's"


def test_times_of_other_frames_than_were_read_are_doubtful():
    assert untimed(30, 30) == untimed(30, 0) == []
    (line,) = untimed(29, 31)
    assert line.startswith("29 frames could be read, but the file gives times of 31")


def test_a_shot_that_is_all_covered_may_be_another_persons():
    status = np.array(["converged"] * 20 + ["mouth covered"] * 12 + ["converged"] * 15)
    cut = np.zeros(47, bool)
    cut[[20, 32]] = True
    found, index = status == "converged", np.arange(100, 147)
    (line,) = unlike_shots(found, status, cut, index)
    assert line.startswith("no frame of the shot from frame 120 to 131 is tracked")
    assert unlike_shots(found, status, np.zeros(47, bool), index) == []  # a hand, say
    some = np.where(np.arange(47) == 25, "converged", status)
    assert unlike_shots(some == "converged", some, cut, index) == []
    gone = np.where(np.arange(47) == 25, "face not found", status)
    assert len(unlike_shots(found, gone, cut, index)) == 1
    none = np.full(47, "mouth covered")
    assert unlike_shots(none == "converged", none, cut, index) == []  # there is no other person
