"""The page of seed 001: tables beside the paper's numbers, what is missed and why, worst rows."""

from __future__ import annotations

import pytest

from abs_engine.papers.odisio2004.goals import GOALS, Goal, goal_rows, score_lines
from abs_engine.papers.odisio2004.page import reproduction_page
from abs_engine.report.document import results_page, table


def sentence(name, mm, *, closed=4, found=4):
    own = {
        "rms_mm": mm, "lips_mm": 1.5 * mm, "worst_frame_mm": 2 * mm, "evaluations_per_frame": 200.0,
        "spoken": 4, "closed": closed, "found": found, "true": 4,
    }  # fmt: skip
    return {"name": name, "text": name, "frames": 99, "tex_lin": own, "la_lin": own}


@pytest.fixture
def results():
    model = {
        "rms_mm": 0.45, "lips_mm": 0.6, "face_mm": 0.3, "evaluations_per_frame": 251.0,
        "closure_recall": 1.0, "closure_precision": 0.9, "sentences": 8, "frames": 800,
        "seconds_per_frame": 0.5, "worst_sentence_mm": 0.8,
    }  # fmt: skip
    return {
        "sentences": {"tex_lin": model, "la_lin": {**model, "rms_mm": 0.3}},
        "sentences_each": [sentence(f"s{k}", 0.1 * k, closed=3 if k == 2 else 4) for k in range(8)],
        "visemes": {"tex_lin": {"median_mm": 0.3}, "tex_cst": {"median_mm": 0.32}},
        "trees": {"vowels": [["i", "e"], ["a"]], "consonants": [["p", "b", "m"]]},
        "practice": [{"what": "axes", "model": "la_lin", "rms_mm": 0.27}],
        "stopping": [{"tolerance": 1e-4, "model": "tex_lin", "mm": 0.4, "evaluations": 250.0}],
        "command": "abs-engine reproduce 001 --sentences 8",
    }  # fmt: skip


def test_what_is_missed_is_told_with_its_reason(results):
    rows = {name: (value, verdict) for name, value, _, verdict in goal_rows(results)}
    assert rows["sentences, tex_lin, mm"][0] == "0.45"
    assert rows["sentences, tex_lin, mm"][1].startswith("not met, by 0.05: most of it")
    assert rows["sentences, la_lin, mm"][1] == "met, by 0.5"
    assert rows["sentences, tex_lin, closures, precision"][1] == "not met, by 0.05"
    value, verdict = rows["visemes, tex_lin over tex_cst, beads"]
    assert value == "0.9375"
    assert verdict.startswith("not met, by 0.137: beads are colours")
    assert rows["visemes, la_lin over la_cst, beads"] == ("not measured", "")
    assert len(score_lines({})) == 1 + len(GOALS)


def test_a_ratio_of_nothing_is_not_measured():
    goal = Goal("a.x", "", 1.0, over="b.x")
    assert goal.measured({"a": {"x": 1.0}}) is None
    assert goal.measured({"a": {"x": 1.0}, "b": {"x": 0.0}}) is None
    assert goal.measured({"a": {"x": 1.0}, "b": {"x": 2.0}}) == 0.5


def test_the_page_has_every_table(results):
    text = reproduction_page(results, [("figure8.svg", "Figure <8>")])
    assert "Not all 77 sentences" in text
    assert "about 300" in text
    assert "{i e} {a}" in text
    assert "{p b m} {f v}" in text
    assert text.count(">worst<") == 5
    assert "tex_lin: 1 of 4; la_lin: 1 of 4" in text
    assert "Figure &lt;8&gt;" in text
    assert "1 of 4" in text
    assert "--sentences 8" in text


def test_an_empty_page_says_so():
    text = reproduction_page({}, [])
    assert "not measured" in text
    assert "<details>" not in text


def test_pages_escape_what_they_are_given():
    shown = results_page("<t>", "<h>", table(("<a>",), [("<b>", "not met, by 1")]), {})
    for raw in ("<t>", "<h>", "<a>", "<b>"):
        assert raw not in shown
    assert 'class="missed"' in shown
