"""Where the mouth's inside is expected while a clip's colours are learned by rounds."""

from __future__ import annotations

import numpy as np
import pytest
from heads import SIZE, head_of, picture_of, seen_at

import abs_engine.tracking.person.calibration_views
from abs_engine.core.camera import Camera
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.detection.mouth_search import CalibrationFrame
from abs_engine.tracking.person.calibration_views import Stand
from abs_engine.tracking.settings.preparation import PREPARATION

CAMERA = Camera.ideal(SIZE)


@pytest.fixture
def places(monkeypatch):
    """What is expected where, (3, H, W), in a round: of a head whose lips are drawn closed."""
    told = []
    monkeypatch.setattr(
        abs_engine.tracking.person.calibration_views,
        "learn_classes",
        lambda _patches, given: told.append(given[0]),
    )
    model = head_of("clara")
    pose = seen_at((0.0, 0.0, 0.0), (0.0, 0.0, 520.0))
    frame = CalibrationFrame(picture_of(model.head, pose, CAMERA), pose)
    stand = Stand(model, [frame], CAMERA, CpuRenderer(), np.zeros(6), np.zeros(model.n_person))
    closed = np.r_[np.zeros(6), model.prototypes[2]][None]

    def of(turn: int) -> np.ndarray:
        stand.learned(closed, turn)
        return told[-1]

    return of


def inside_of(places: np.ndarray) -> float:
    """Of where closed lips are, how much may be the mouth's inside."""
    _, lips, inside = places
    sure = lips > 0.6 * lips.max()
    return float(np.mean(inside[sure] / lips[sure]))


def test_closed_lips_may_less_and_less_be_open(places):
    """At first much: else lips that rest parted are never found to be."""
    shares = [inside_of(places(turn)) for turn in range(len(PREPARATION.view_rounds))]
    assert shares == sorted(shares, reverse=True)
    assert shares[1] > 1.2 * shares[-1] > 0


def test_a_round_expects_what_its_share_says(places):
    """Where closed lips are drawn, hardly anything else is: the share alone makes them open."""
    for turn, (_, share) in enumerate(PREPARATION.view_rounds):
        if turn > 0:  # in the first, open postures are drawn, too
            assert inside_of(places(turn)) == pytest.approx(share, rel=0.15), turn
