"""Frames that are explained less than the rest of their clip are marked, and doubted."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.fit.settings import BELIEF
from abs_engine.tracking.results.less_explained import doubted, less_explained, shortfall
from abs_engine.tracking.results.run_table import sure_frames
from abs_engine.tracking.results.run_warnings import partly_explained
from abs_engine.tracking.settings.frames import FRAME_LOOP

USUAL, WORSE = 0.92, 0.75
"""How much is explained of a clip's frames, and of those with text over the lips."""


def scores(count: int, under: int) -> np.ndarray:
    """Scores of a clip, text over the lips in its last frames."""
    return np.r_[np.full(count - under, USUAL), np.full(under, WORSE)]


def test_frames_fall_short_of_the_median_one():
    short = shortfall(np.r_[scores(20, 6), 0.99, np.nan])
    assert short[:14].max() == 0.0
    assert short[14:20] == pytest.approx(USUAL - WORSE)
    assert short[20:].tolist() == [0.0, 0.0]  # a better one, and one without a score
    assert less_explained(short).tolist() == [False] * 14 + [True] * 6 + [False] * 2


def test_too_few_frames_say_nothing():
    few = FRAME_LOOP.fewest - 1
    assert shortfall(scores(few, 3)).max() == 0.0
    assert shortfall(scores(few + 1, 3)).max() > 0.1
    assert shortfall(np.full(30, np.nan)).max() == 0.0


def test_deviations_grow_with_what_is_not_explained():
    free, growth = BELIEF.unexplained
    short = np.array([0.0, free, free + 0.02, free + 0.1, 0.0])
    own = np.array([1.0, 1.0, 1.0, 1.0, np.nan])
    closed = np.array([0.9, 0.9, 0.9, 0.1, np.nan])
    found = doubted({"aperture_sd": own, "closed_probability": closed}, short)
    grown = np.hypot(1.0, growth * np.array([0.0, 0.0, 0.02, 0.1]))
    assert found["aperture_sd"][:4] == pytest.approx(grown)
    assert found["closed_probability"][:2].tolist() == [0.9, 0.9]
    assert 0.5 < found["closed_probability"][2] < 0.9  # less sure, on the same side
    assert 0.1 < found["closed_probability"][3] < 0.5
    assert np.isnan(found["aperture_sd"][4])
    assert np.isnan(found["closed_probability"][4])


def test_many_such_frames_are_warned_of_and_named():
    index = np.arange(100, 140)
    less = np.zeros(40, bool)
    less[[10, 12, 13]] = True
    assert partly_explained(less, index) == []  # as a quick turn leaves
    less[[20, 21, 30]] = True
    (line,) = partly_explained(less, index)
    assert line.startswith("in 6 of 40 frames, between 110 and 130, the drawn mouth explains less")
    assert partly_explained(np.zeros(0, bool), np.zeros(0, int)) == []


def test_such_frames_are_not_learned_from():
    yes, no = np.ones(3, bool), np.zeros(3, bool)
    run = {"found": yes, "covered": no, "contradicted": no}
    assert sure_frames(run).all()  # a run of an older version
    assert sure_frames({**run, "less_explained": np.array([False, True, False])}).tolist() == [
        True, False, True,
    ]  # fmt: skip
