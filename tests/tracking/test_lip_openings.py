"""The distances between inner lips say how far a mouth is open, and nothing else."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from drawn import CAMERA, anybody, projected
from heads import seen_at

from abs_engine.tracking import lip_openings
from abs_engine.tracking.landmark_fit import fit_frame
from abs_engine.tracking.landmark_rays import SeenRays
from abs_engine.tracking.landmarks import COUNT, INNER_RING, OUTER_RING
from abs_engine.tracking.lip_openings import LipOpenings
from abs_engine.tracking.settings.landmarks import LANDMARK_EVIDENCE

POSE = seen_at([0.05, -0.1, 0.1], [20, -30, 700])
LOWER, UPPER = INNER_RING[1:10], INNER_RING[19:10:-1]
MIDDLE = 4  # of the nine
MODES = 10  # of the mouth, the first


@cache
def average():
    """The landmarks of the average person."""
    return anybody().person(np.zeros(len(anybody().identity)))


@cache
def opening():
    """The unit step of a posture (M,) that opens the mouth most."""
    across = (average().posture[:, LOWER] - average().posture[:, UPPER])[..., 1].mean(axis=1)
    return -across / np.linalg.norm(across)


def points_of(posture):
    return average().mean + np.tensordot(posture, average().posture, 1)


def said(points, posture, shape=None, trust=None):
    """What is said of a posture by landmarks seen where points (468, 3), mm, are."""
    seen = SeenRays.of(projected(points, POSE), CAMERA, trust)
    return LipOpenings.of(average() if shape is None else shape, seen).equations(POSE, posture)


def gap(posture):
    """Distance of the inner lips' middles, mm."""
    points = points_of(posture)
    return float(points[UPPER[MIDDLE], 1] - points[LOWER[MIDDLE], 1])


def thick(points, by):
    """Points whose outer lips lie farther out, mm."""
    out, half = points.copy(), len(OUTER_RING) // 2
    out[OUTER_RING[1:half], 1] -= by
    out[OUTER_RING[half + 1 :], 1] += by
    return out


def test_a_mouth_as_far_open_as_it_is_seen_is_left_alone():
    posture = 0.5 * opening()
    np.testing.assert_allclose(said(points_of(posture), posture).gradient, 0, atol=1e-6)


@pytest.mark.parametrize("wider", [0.1, -0.1])
def test_a_step_goes_to_the_opening_that_is_seen(wider):
    posture = 0.5 * opening()
    found = said(points_of((0.5 + wider) * opening()), posture)
    step = -np.linalg.lstsq(found.information, found.gradient, rcond=1e-6)[0]
    missing = gap((0.5 + wider) * opening()) - gap(posture)
    assert abs(missing) > 0.3
    assert gap(posture + step) - gap(posture) == pytest.approx(missing, rel=0.1)


def test_the_slope_is_how_the_gradient_changes():
    """Where the mouth is as far open as it is seen, so that weights do not matter."""
    posture = 0.5 * opening()
    points, slope = points_of(posture), said(points_of(posture), posture).slope
    for k, step in enumerate(1e-4 * np.eye(len(posture))[:MODES]):
        ahead, behind = (said(points, posture + s).gradient for s in (step, -step))
        np.testing.assert_allclose(
            (ahead - behind) / 2e-4, slope[:, k], atol=1e-3 * np.abs(slope).max()
        )


@pytest.mark.parametrize(("share", "left"), [(1.0, 0.0), (0.5, 0.5), (0.0, 1.0)])
def test_a_share_of_what_moves_either_lip_in_depth_is_left_out(monkeypatch, share, left):
    def curvatures(of):
        settings = replace(LANDMARK_EVIDENCE, opening_depth=of)
        monkeypatch.setattr(lip_openings, "LANDMARK_EVIDENCE", settings)
        found = said(points_of(opening()), np.zeros(len(opening())))
        for lip in (LOWER, UPPER):
            depth = (average().posture[:, lip] @ POSE.rotation.T)[..., 2].mean(axis=1)
            yield depth @ found.information @ depth

    whole = np.array(list(curvatures(0.0)))
    assert (whole > 1).all()
    np.testing.assert_allclose(list(curvatures(share)), left * whole, atol=1e-4 * whole.max())


def test_lips_that_are_seen_thicker_do_not_open_the_mouth():
    """Without the landmarks of the inner lips, they do."""
    points = thick(points_of(np.zeros(len(opening()))), 3.0)
    blind = np.ones(COUNT)
    blind[INNER_RING] = 0.0
    seen = projected(points, POSE)
    opened = [
        gap(fit_frame(average(), seen, CAMERA, trust=trust).posture) - gap(0 * opening())
        for trust in (None, blind)
    ]
    assert opened[1] > 1.0
    assert abs(opened[0]) < 0.5 * opened[1]


def test_one_that_is_far_off_counts_less():
    posture = np.zeros(len(opening()))
    near, far = (said(points_of(k * opening()), posture) for k in (0.05, 3.0))
    assert np.linalg.norm(far.gradient) < 20 * np.linalg.norm(near.gradient)  # 60 times as far
    assert np.trace(far.information) < 0.5 * np.trace(near.information)


def test_landmarks_that_are_not_trusted_say_nothing():
    posture, half = np.zeros(len(opening())), np.full(COUNT, 0.5)
    seen = points_of(0.2 * opening())
    whole = said(seen, posture)
    np.testing.assert_allclose(said(seen, posture, trust=half).gradient, 0.5 * whole.gradient)
    none = half.copy()
    none[LOWER] = 0.0
    assert not said(seen, posture, trust=none).information.any()


def test_lips_that_face_away_hardly_count():
    posture = np.zeros(len(opening()))
    away = replace(average(), normals=-average().normals)
    seen = points_of(posture)
    shown, hidden = (np.trace(said(seen, posture, one).information) for one in (average(), away))
    assert hidden < 1.1 * LANDMARK_EVIDENCE.guessed / 0.5 * shown


def test_what_the_network_sees_a_person_off_by_is_taken_off():
    bias = np.zeros((COUNT, 2))
    bias[LOWER, 1] = 1.0
    posture = np.zeros(len(opening()))
    found = said(points_of(posture), posture, replace(average(), bias=bias))
    step = -np.linalg.lstsq(found.information, found.gradient, rcond=1e-6)[0]
    assert gap(step) - gap(posture) == pytest.approx(-1.0, abs=0.2)
