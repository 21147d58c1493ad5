"""Frames that are explained less than the rest of their clip are marked, and doubted."""

from __future__ import annotations

from dataclasses import replace
from statistics import NormalDist

import numpy as np
import pytest
from runs import toy_result, toy_setting

from abs_engine.fit.belief import Belief
from abs_engine.fit.settings import BELIEF
from abs_engine.tracking.frame.clip_setting import GREY
from abs_engine.tracking.results.less_explained import (
    doubted,
    less_explained,
    partly_explained,
    shortfall,
)
from abs_engine.tracking.results.run_table import sure_frames
from abs_engine.tracking.runs.recorder import Recorder
from abs_engine.tracking.settings.doubts import DOUBTS

BELIEVED = Belief(
    1.0, 1.0, 1.0, np.ones_like(toy_result(0).lips), np.full(3, 0.01), np.ones(3), 12.0
)
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
    few = DOUBTS.fewest - 1
    assert shortfall(scores(few, 3)).max() == 0.0
    assert shortfall(scores(few + 1, 3)).max() > 0.1
    assert shortfall(np.full(30, np.nan)).max() == 0.0


def test_deviations_grow_with_what_is_not_explained():
    free, growth = BELIEF.unexplained
    short = np.array([0.0, free, free + 0.02, free + 0.1, 0.0])
    own = np.array([1.0, 1.0, 1.0, 1.0, np.nan])
    closed = np.array([0.9, 0.9, 0.9, 0.0, np.nan])
    aperture = np.array([0.0, 0.0, 0.0, 14.0, np.nan])
    told = {"aperture_sd": own, "closed_probability": closed, "aperture": aperture}
    found = doubted(told, short)
    grown = np.hypot(1.0, growth * np.array([0.0, 0.0, 0.02, 0.1]))
    assert found["aperture_sd"][:4] == pytest.approx(grown)
    assert found["closed_probability"][:2].tolist() == [0.9, 0.9]
    assert 0.5 < found["closed_probability"][2] < 0.9  # less sure, on the same side
    assert found["closed_probability"][3] == pytest.approx(NormalDist(14.0, grown[3]).cdf(1.0))
    assert np.isnan(found["aperture_sd"][4])
    assert np.isnan(found["closed_probability"][4])


def test_many_such_frames_are_warned_of_and_named():
    index = np.arange(100, 140)
    less = np.zeros(40, bool)
    less[[10, 12, 13]] = True
    assert partly_explained(less, index) == []  # as a quick turn leaves
    less[[20, 21, 30]] = True
    (line,) = partly_explained(less, index)
    assert line.startswith("in 6 of 40 tracked frames, between frames 110 and 130, the drawn mouth")
    assert partly_explained(np.zeros(0, bool), np.zeros(0, int)) == []


def test_such_frames_are_not_learned_from():
    yes, no = np.ones(3, bool), np.zeros(3, bool)
    run = {"found": yes, "covered": no, "contradicted": no}
    assert sure_frames(run).all()  # a run of an older version
    assert sure_frames({**run, "less_explained": np.array([False, True, False])}).tolist() == [
        True, False, True,
    ]  # fmt: skip


def recorded(**changes):
    """The record of 40 frames; in the last six text lies over the lips."""
    recorder = Recorder(toy_setting())
    for k, score in enumerate(scores(40, 6)):
        found = replace(toy_result(k), score=score, terms={"colour": 9.0}, belief=BELIEVED)
        recorder.add(replace(found, **changes))
    return recorder.record()


def test_a_run_marks_them_and_warns_and_its_deviations_grow():
    record = recorded()
    arrays, marks = record.arrays, np.arange(40) >= 34
    np.testing.assert_array_equal(arrays["less_explained"], marks)
    assert (arrays["aperture_sd"][~marks] == BELIEVED.aperture).all()
    assert arrays["aperture_sd"][marks].min() > 5.0
    assert record.summary["less_explained_frames"] == 6
    (line,) = (w for w in record.summary["warnings"] if "explains less of the picture" in w)
    assert "less_explained in results.csv marks them" in line
    table = list(record.table())
    column = table[0].index("less_explained")
    assert [row[column] for row in table[1:]] == marks.astype(int).tolist()


@pytest.mark.parametrize("changes", [{"terms": {"texture": 9.0}}, {"status": GREY}, {"terms": {}}])
def test_scores_of_something_else_than_colour_throw_no_doubt(changes):
    record = recorded(**changes)
    assert not record.arrays["less_explained"].any()
    assert (record.arrays["aperture_sd"] == BELIEVED.aperture).all()
