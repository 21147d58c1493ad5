"""An outline keeps its lips' thickness: turned inside out it costs a lot, speech costs nothing."""

from __future__ import annotations

import numpy as np
import pytest
from runs import toy_model

from abs_engine.face.contact import lip_gaps, lip_heights, pinching
from abs_engine.face.head import PROTOTYPES
from abs_engine.fit.head_frame import contact_prior
from abs_engine.fit.settings import HEAD_FIT

MODEL = toy_model()
NOBODY = np.zeros(MODEL.n_person)
THIN, THICK = (contact_prior(MODEL, NOBODY, thick=thick) for thick in (False, True))
P = MODEL.n_expression


def heights(weights, person=NOBODY):
    height, change = lip_heights(MODEL.held(person), MODEL.rings)
    return height + change @ weights


def inside_out():
    """The smallest posture in which both lips' inner edges lie beyond the outer ones."""
    height, change = lip_heights(MODEL.held(NOBODY), MODEL.rings)
    return np.linalg.lstsq(change, -3.0 - height, rcond=None)[0]


def test_heights_are_those_of_the_mesh():
    """From the outer to the inner contour, upper lip then lower, measured on the vertices."""
    weights = np.random.default_rng(0).normal(0, 0.7, P)
    vertices = MODEL.held(NOBODY).vertices(weights)
    outer = vertices[MODEL.rings["outer"]]
    upper, lower = np.split(heights(weights), 2)
    middle = outer[:, 0].mean()
    at = outer[np.argsort(np.abs(outer[:, 0] - middle))[:4]]
    top, bottom = at[:, 1].max(), at[:, 1].min()
    for name, tall, edge in (("upper", upper, top), ("lower", lower, bottom)):
        ring = vertices[MODEL.rings[name]]
        inner = ring[np.abs(ring[:, 0] - middle).argmin(), 1]
        assert tall[3] == pytest.approx(abs(edge - inner), abs=1.0)


def test_at_rest_lips_are_some_millimetres_high():
    upper, lower = np.split(heights(MODEL.prototypes[0]), 2)
    assert len(upper) == len(lower) == 7
    assert 4.0 < upper[3] < 14.0
    assert 4.0 < lower[3] < 16.0
    np.testing.assert_allclose(upper, upper[::-1], atol=0.5)  # of both sides alike
    np.testing.assert_allclose(lower, lower[::-1], atol=0.5)


def test_a_person_with_higher_lips_has_higher_lips():
    more = MODEL.person({"upper lip height": 2.0})
    upper, lower = np.split(heights(MODEL.prototypes[0], more) - heights(MODEL.prototypes[0]), 2)
    assert upper[2:5].min() > 0.5
    assert np.abs(lower).max() < 0.5 * upper.max()


@pytest.mark.parametrize("k", range(len(PROTOTYPES)))
def test_every_posture_that_a_fit_starts_from_costs_nothing_more(k):
    x = np.r_[np.zeros(6), MODEL.prototypes[k]]
    assert THICK.negative_log(x) == pytest.approx(THIN.negative_log(x), abs=0.3)


def test_an_outline_inside_out_costs_a_lot():
    weights = inside_out()
    assert heights(weights).mean() < -1.0
    x = np.r_[np.zeros(6), weights]
    assert THICK.negative_log(x) > THIN.negative_log(x) + 50.0


def test_the_cost_begins_at_the_least_thickness():
    rest = heights(MODEL.prototypes[0])
    way = inside_out() - MODEL.prototypes[0]
    for share in np.linspace(0, 1, 21):
        x = MODEL.prototypes[0] + share * way
        thin = (heights(x) < HEAD_FIT.least_thickness * rest).any()
        full = np.r_[np.zeros(6), x]
        more = THICK.negative_log(full) - THIN.negative_log(full)
        assert (more > 1e-9) == thin


def test_the_pose_costs_nothing():
    rng = np.random.default_rng(0)
    x = np.r_[rng.normal(0, 5, 6), MODEL.prototypes[4]]
    assert THICK.negative_log(x) == THICK.negative_log(np.r_[np.zeros(6), MODEL.prototypes[4]])


def test_both_sides_of_a_pinched_mouth_count_alike():
    gap, slope = (np.random.default_rng(1).normal(size=size) for size in (9, (9, P)))
    for ours, mirrored in zip(pinching(gap, slope), pinching(gap[::-1], slope[::-1]), strict=True):
        np.testing.assert_allclose(ours, mirrored)


def test_a_mouth_that_opens_beside_its_middle_alone_costs_a_lot():
    """Two openings with a bridge between them: no recorded mouth shows that."""
    gap, slope = lip_gaps(MODEL.held(NOBODY), MODEL.rings)
    wanted = np.array([0.0, 2.0, 4.0, 2.0, 0.0, 2.0, 4.0, 2.0, 0.0])
    pinched = np.linalg.lstsq(slope, wanted - gap, rcond=None)[0]
    by, move = pinching(gap, slope)
    assert (by + move @ pinched)[0] < -1.0
    x = np.r_[np.zeros(6), pinched]
    assert THICK.negative_log(x) > THIN.negative_log(x) + 2.0
    for prototype in MODEL.prototypes:
        assert (by + move @ prototype)[0] > 0
