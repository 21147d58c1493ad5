"""Two calibrations are made, more where they explain little, and the best is kept."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from runs import toy_model, toy_setting

from abs_engine.core.errors import TooFewPixelsError
from abs_engine.core.geometry import FACING, Pose
from abs_engine.tracking.detection.mouth_search import CalibrationFrame, shifted
from abs_engine.tracking.person import multistart
from abs_engine.tracking.person.calibration_views import Stand
from abs_engine.tracking.person.identity_fit import Calibration, shift_deviation
from abs_engine.tracking.person.multistart import calibrate_well
from abs_engine.tracking.settings.preparation import PREPARATION

STARTS = (PREPARATION.higher, "fuller", PREPARATION.lower, *PREPARATION.nearer_and_farther)
SETTING = toy_setting()
MODEL = toy_model()
POSE = Pose(FACING, [0.0, 30.0, 600.0])
FRAMES = [CalibrationFrame(np.zeros((4, 4, 3), np.uint8), POSE)]
OWN = np.array([0.01, -0.02, 0.03, 1.0, 2.0, 3.0])


def silent(_text):
    """Tell nobody."""


def attempt(monkeypatch, scores, model=MODEL, tell=silent):
    """Calibrate with made-up scores, one for each start; also the poses that were tried.

    The third attempt, and no other, begins with full lips where the first did.
    """
    tried = []

    def calibrate(stand, _known, _seen, tell):
        tried.append(stand.frames[0].pose)
        tell("round 1 of 3")
        assert ((stand.person[1:3] > 0.5).sum() == 2) == (len(tried) == 3)
        return Calibration(np.full(1, len(tried)), OWN, SimpleNamespace(), np.zeros((1, 16)))

    monkeypatch.setattr(multistart, "calibrate", calibrate)
    monkeypatch.setattr(multistart, "explained", lambda *a: scores[int(a[-1].person[0]) - 1])
    monkeypatch.setattr(multistart, "log_evidence", lambda _stand, given: scores[: len(given)])
    return calibrate_well(model, FRAMES, SETTING.camera, SETTING.renderer, tell), tried


@pytest.mark.parametrize("scores", [[PREPARATION.good_score, 0.0], [PREPARATION.good_score, 1.0]])
def test_beside_a_good_calibration_only_a_higher_place_is_tried(monkeypatch, scores):
    found, tried = attempt(monkeypatch, scores)
    assert len(tried) == 2
    assert found.person[0] == 1 + np.argmax(scores)
    move = np.array([0.0, 0.0, 0.0, 0.0, PREPARATION.higher[0] * np.argmax(scores), 0.0])
    np.testing.assert_array_equal(found.shift, OWN + move)


def test_one_that_is_not_poor_is_tried_again_fuller_higher_and_lower_only(monkeypatch):
    tried = attempt(monkeypatch, [PREPARATION.poor_score, 0.1, 0.1, 0.1])[1]
    assert len(tried) == 4
    assert len({pose.translation[2] for pose in tried}) == 1


@pytest.mark.parametrize("winner", range(1 + len(STARTS)))
def test_the_best_is_kept_and_its_shift_counts_from_the_given_poses(monkeypatch, winner):
    scores = [0.5] * (1 + len(STARTS))
    scores[winner] = 0.7
    found, tried = attempt(monkeypatch, scores)
    assert len(tried) == 1 + len(STARTS)
    assert found.person[0] == winner + 1
    there = shifted(tried[winner], OWN, MODEL.pivot)
    ours = shifted(POSE, found.shift, MODEL.pivot)
    np.testing.assert_allclose(ours.apply(MODEL.pivot), there.apply(MODEL.pivot), atol=1e-9)
    np.testing.assert_allclose(ours.rotation, there.rotation)


def test_each_round_of_each_start_is_announced(monkeypatch):
    learning, said = "learning the clip's colours, fitting the mouth", []

    def stop(text):
        said.append(text)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        calibrate_well(MODEL, FRAMES, SETTING.camera, SETTING.renderer, stop, placed=True)
    assert said == [f"{learning}, round 1 of {len(PREPARATION.view_rounds)}"]
    said.clear()
    attempt(monkeypatch, [PREPARATION.poor_score, 0.1, 0.1, 0.1], tell=said.append)
    others = [f"fitting the mouth from elsewhere, {k} of 3, round 1 of 3" for k in (1, 2, 3)]
    assert said == [f"{learning}, round 1 of 3", *others]


def test_a_known_head_is_not_looked_for_elsewhere(monkeypatch):
    known = replace(MODEL, scene=MODEL.held(np.zeros(MODEL.n_person)))
    assert known.known
    assert len(attempt(monkeypatch, [0.1], known)[1]) == 1


@pytest.mark.parametrize("placed", [False, True])
def test_a_place_that_was_told_stays_and_leaves_more_open(monkeypatch, placed):
    faces, given = np.array([0.0, 0.1, 0.2, 10.0, 20.0, 30.0]), []

    def calibrate(stand, _known, seen, _tell):
        given.append((stand.frames[0].pose, seen))
        return Calibration(np.zeros(1), OWN, SimpleNamespace(), np.zeros((1, 16)))

    monkeypatch.setattr(multistart, "shift_of_faces", lambda *_: faces)
    monkeypatch.setattr(multistart, "calibrate", calibrate)
    monkeypatch.setattr(multistart, "explained", lambda *_: PREPARATION.good_score)
    monkeypatch.setattr(multistart, "log_evidence", lambda _stand, given: np.zeros(len(given)))
    calibrate_well(MODEL, FRAMES, SETTING.camera, SETTING.renderer, silent, placed=placed)
    there = POSE if placed else shifted(POSE, faces, MODEL.pivot)
    assert [seen for _, seen in given] == [not placed] * 2
    np.testing.assert_allclose(given[0][0].translation, there.translation)
    np.testing.assert_allclose(given[0][0].rotation, there.rotation)
    stand = Stand(MODEL, FRAMES * 2, SETTING.camera, SETTING.renderer, OWN, np.zeros(1))
    assert (shift_deviation(stand, True) < shift_deviation(stand, False)).all()


def test_known_colours_are_not_learned_again(monkeypatch):
    given = []

    def calibrate(_stand, known, _seen, _tell):
        given.append(known)
        return Calibration(np.zeros(1), OWN, known, np.zeros((1, 16)))

    monkeypatch.setattr(multistart, "calibrate", calibrate)
    monkeypatch.setattr(multistart, "explained", lambda *_: 0.1)
    monkeypatch.setattr(multistart, "log_evidence", lambda _stand, given: np.zeros(len(given)))
    colours = SimpleNamespace()
    found = calibrate_well(MODEL, FRAMES, SETTING.camera, SETTING.renderer, silent, colours)
    assert found.classes is colours
    assert given == [colours] * (1 + len(STARTS))


def test_a_start_without_colours_to_learn_is_left_out(monkeypatch):
    tried = []

    def calibrate(_stand, known, _seen, _tell):
        tried.append(known)
        if len(tried) in (2, 4):
            raise TooFewPixelsError("only 3 pixels show lips", "give a larger face")
        return Calibration(np.full(1, len(tried)), OWN, SimpleNamespace(), np.zeros((1, 16)))

    monkeypatch.setattr(multistart, "calibrate", calibrate)
    monkeypatch.setattr(multistart, "explained", lambda *_: 0.1)
    monkeypatch.setattr(
        multistart, "log_evidence", lambda _stand, given: [c.person[0] for c in given]
    )
    found = calibrate_well(MODEL, FRAMES, SETTING.camera, SETTING.renderer, silent)
    assert len(tried) == 1 + len(STARTS)
    assert found.person[0] == len(tried)
