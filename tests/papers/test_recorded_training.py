"""Lips learned from five seconds, in other motion: the split of their error, and its report."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from lip_clips import CAMERA, FRONT, HEADS, SPEAKER, lips, picture

from abs_engine.fit.shell import problem_of
from abs_engine.papers.basu1998 import filmed
from abs_engine.papers.basu1998.collected import Report
from abs_engine.papers.basu1998.experiment import lip_error
from abs_engine.papers.basu1998.page import reproduction_page
from abs_engine.papers.basu1998.recorded_training import PARTS, WEAK, _by_dots, errors
from abs_engine.papers.basu1998.reproduce import _recorded
from abs_engine.render.cpu import CpuRenderer
from abs_engine.studio.scenefile import parse_scene

WHICH = (10, 18)
"""Frames of rounded speech, which the lips never saw."""


class View:
    """Frames that a camera saw, with their truth."""

    camera = CAMERA

    def __len__(self):
        return len(WHICH)

    def vertices(self, frame):
        return HEADS[WHICH[frame]]

    def pose(self, _frame):
        return FRONT

    def pictures(self):
        return (picture(k, FRONT) for k in WHICH)


@pytest.fixture(scope="module")
def split():
    return errors(SPEAKER, lips(), View(), CpuRenderer())


def test_the_picture_adds_to_what_dots_and_modes_leave(split):
    assert tuple(split) == PARTS
    assert 0 < split["interpolation_mm"] < split["modes_mm"]
    assert split["modes_mm"] < min(split["picture_mm"], split["mm"])
    assert max(split.values()) < 5


def test_a_weak_prior_says_next_to_nothing_of_the_same_shapes():
    own = lips()
    usual = replace(own.setting(CAMERA, CpuRenderer()), seen=None)
    weak = replace(usual, prior_width=WEAK)
    costs = [
        problem_of(setting, FRONT, {}).priors[0].negative_log(np.r_[np.zeros(6), own.starts[1]])
        for setting in (usual, weak)
    ]
    assert costs[0] > 1
    assert costs[1] == pytest.approx(costs[0] / WEAK**2)
    assert usual.scene is weak.scene  # the starts draw the same


def test_what_the_modes_lack_is_the_motion_that_they_never_saw(split):
    """The nearest shape in more modes lies nearer, and exact dots leave what is between them."""
    own, heads = lips(), HEADS[list(WHICH)].astype(np.float64)
    truth = np.stack([own.model.shell.nodes(head) for head in heads])
    reached = _by_dots(SPEAKER, own, heads)
    between = [lip_error(nodes, true) ** 2 for nodes, true in zip(reached, truth, strict=True)]
    assert split["interpolation_mm"] == pytest.approx(np.sqrt(np.mean(between)))
    physics = own.training.physics
    few = replace(physics, modes=physics.modes[:4], variances=physics.variances[:4])
    nearest = few.shape(few.coefficients(reached))
    fewer = [lip_error(nodes, true) ** 2 for nodes, true in zip(nearest, truth, strict=True)]
    assert np.sqrt(np.mean(fewer)) > split["modes_mm"]


def test_fronts_are_filmed_of_everybody_from_the_front():
    amount = filmed.Amount(("mei", "walter"), 50, 12, 0)
    scene = parse_scene(filmed.scene_of(amount, 3, filmed.FRONTS))
    tests = [clip for clip in scene.clip if clip.name.endswith("-test")]
    assert [clip.speaker for clip in tests] == ["mei", "walter"]
    assert {clip.cameras for clip in tests} == {(filmed.FRONT,)}
    assert {clip.frames for clip in tests} == {50}


def test_the_page_has_a_row_for_each_person_and_all():
    of = dict(zip(PARTS, (0.281, 0.432, 2.171, 1.901), strict=True))
    given = {"motion": "a recording", "people": {"mei": of}, "all": of}
    text = reproduction_page({"recorded": given}, [], [])
    assert text.count("0.28 mm") == text.count("0.43 mm") == text.count("2.17 mm") == 2
    assert "--quick leaves it out" in reproduction_page({"recorded": None}, [], [])


def test_it_is_left_out_by_quick_and_without_the_recording(tmp_path, monkeypatch):
    monkeypatch.setenv("ABS_ENGINE_DATA", str(tmp_path))
    for amount in (filmed.QUICK, filmed.FULL):
        report = Report(tmp_path / "report", tmp_path, CpuRenderer(), SPEAKER, 0, print, amount)
        assert _recorded(report) is None
    assert not (tmp_path / "report").exists()
