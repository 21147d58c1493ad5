"""What a user is told of a run that is to be doubted, and that a sound one is not."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.tracking.doubt import LEAST_AGREEMENT, LEAST_SEPARABILITY, doubts

GOOD = {"upper_lip": 0.95, "lower_lip": 0.9}
TALK = 6 + 5 * np.sin(np.arange(40) / 3)
NONE = [False] * 40


def test_a_sound_run_has_no_doubts():
    noise = np.random.default_rng(0).normal(0, 1, 40)
    assert doubts(TALK + noise, TALK, NONE, GOOD) == []


def test_lips_of_the_skins_colour_are_told_each():
    (line,) = doubts(TALK, TALK, NONE, {"upper_lip": 0.61, "lower_lip": 0.72})
    assert "nearly the same colour" in line
    assert "upper lip 61%, lower lip 72%" in line


@pytest.mark.parametrize(("told", "lines"), [(-0.01, 1), (0.01, 0)])
def test_where_they_begin_to_be_the_same(told, lines):
    both = dict.fromkeys(GOOD, LEAST_SEPARABILITY + told)
    assert len(doubts(TALK, TALK, NONE, both)) == lines


@pytest.mark.parametrize(("told", "lines"), [(-0.01, 1), (0.01, 0)])
def test_colours_that_open_the_mouth_less_than_landmarks(told, lines):
    found = doubts(TALK, TALK, NONE, GOOD, LEAST_AGREEMENT + told)
    assert len(found) == lines
    assert all("opens 69% as far as by landmarks" in line for line in found)


def test_colours_that_open_it_the_wrong_way_open_it_by_nothing():
    (line,) = doubts(TALK, TALK, NONE, GOOD, -0.4)
    assert "opens 0% as far" in line


def test_separability_that_was_not_measured_is_no_doubt():
    assert doubts(TALK, TALK, NONE, {}) == []


def test_apertures_that_differ_as_much_as_they_vary():
    (line,) = doubts(TALK.mean() + 0 * TALK - 3, TALK, NONE, GOOD)
    apart = np.sqrt(np.mean((TALK.mean() - 3 - TALK) ** 2))
    assert f"differs by {apart:.1f} mm" in line
    assert "overlay" in line


def test_a_mouth_that_hardly_moves_cannot_be_judged_by_how_it_moves():
    still, moving = np.full(40, 3.0), 3 + np.sin(np.arange(40) / 3) * 1.2
    assert doubts(still + 2.0, still, NONE, GOOD) == []
    assert len(doubts(moving + 2.0, moving, NONE, GOOD)) == 1


def test_lost_frames_count_for_neither():
    lost = TALK.copy()
    lost[::2] = np.nan
    assert doubts(lost, TALK, NONE, GOOD) == []
    assert len(doubts(lost + 6, TALK, NONE, GOOD)) == 1
    lost[9:] = np.nan
    assert doubts(lost + 6, TALK, NONE, GOOD) == []  # too few to say


def test_frames_that_were_held_to_the_landmarks():
    held = [k < 10 for k in range(40)]
    (line,) = doubts(TALK, TALK, held, GOOD)
    assert line.startswith("in 25% of the frames what is drawn led off the lips")
    assert doubts(TALK, TALK, [k < 4 for k in range(40)], GOOD) == []


def test_all_of_it_at_once_and_nothing_at_all():
    bad = dict.fromkeys(GOOD, 0.55)
    assert len(doubts(TALK + 9, TALK, [True] * 40, bad)) == 3
    assert doubts(np.array([]), np.array([]), [], {}) == []
