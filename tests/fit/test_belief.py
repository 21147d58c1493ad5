"""Standard deviations: exact where all is Gaussian, wider where a picture says less."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from test_newton import problem
from test_track_fit import ALL, BASE, MODEL, SETTING, N, start

from abs_engine.compare.prior import GaussianPrior, InformationPrior
from abs_engine.core.scene import ClassMaps
from abs_engine.fit.belief import ROTATION, Unknown, belief_of, share_of_landmarks
from abs_engine.fit.head_frame import COLOUR, contact_prior
from abs_engine.fit.problem import Problem
from abs_engine.fit.settings import BELIEF
from abs_engine.optimise.newton import Newton

FACE = SETTING.face


def told(information):
    """A problem of a Gaussian alone, about a posture that is open."""
    mean = np.r_[np.zeros(6), MODEL.prototypes[2]]
    return Problem(BASE, FACE.blocks, {}, (InformationPrior(mean, information),)), mean


def test_poor_colours_leave_more_open():
    made, x = told(400 * np.eye(N))
    grey, colour = (
        belief_of(made, FACE.looking(colour=SimpleNamespace(poor=poor)), x)
        for poor in (True, False)
    )
    assert belief_of(made, FACE, x).aperture == colour.aperture < grey.aperture
    assert colour.width < grey.width


def test_a_gaussian_gives_its_own_covariance(monkeypatch):
    for name in ("APERTURE", "WIDTH"):
        monkeypatch.setattr(f"abs_engine.fit.belief.{name}", Unknown())
    for name in ("ROTATION", "TRANSLATION"):
        monkeypatch.setattr(f"abs_engine.fit.belief.{name}", (Unknown(),) * 3)
    rng = np.random.default_rng(0)
    root = 16 * (rng.normal(size=(N, N)) + 3 * np.eye(N))
    made, x = told(root @ root.T)
    found = belief_of(made, FACE, x)
    draws = rng.multivariate_normal(x, np.linalg.inv(root @ root.T), 4000)
    measured = np.array([FACE.measures(d[6:])[1:] for d in draws])
    assert found.width == pytest.approx(measured[:, 0].std(), rel=0.05)
    assert found.aperture == pytest.approx(measured[:, 1].std(), rel=0.05)
    assert found.rotation == pytest.approx(draws[:, :3].std(axis=0), rel=0.05)
    places = [made.frame.pose(x + d).translation for d in 1e-6 * np.eye(N)]
    slope = (places - made.frame.pose(x).translation) / 1e-6
    varied = np.diag(slope.T @ np.linalg.inv(root @ root.T) @ slope)
    assert found.translation == pytest.approx(np.sqrt(varied), rel=1e-3)
    assert found.lips.shape == (sum(FACE.ring_sizes), 3)
    assert found.closed < 0.01


def test_what_is_held_is_sure():
    made, x = told(np.eye(N))
    found = belief_of(replace(made, free=("posture",)), FACE, x)
    free = belief_of(made, FACE, x)
    assert (found.rotation < free.rotation).all()
    assert found.rotation == pytest.approx([one.least for one in ROTATION])
    assert found.aperture == pytest.approx(free.aperture)


def test_a_picture_that_says_less_leaves_more_open():
    made = problem(0)
    x = Newton().minimise(made, start(0, ALL), made.spec).x
    colour = made.terms[COLOUR]
    less = replace(made, terms={COLOUR: replace(colour, observations=0.1 * colour.observations)})
    sure, unsure = belief_of(made, FACE, x), belief_of(less, FACE, x)
    assert unsure.width > 1.2 * sure.width
    assert unsure.lips.mean() > sure.lips.mean()


def test_closed_lips_are_probably_closed():
    made, _ = told(400.0 * np.eye(N))
    for posture, closed in ((MODEL.prototypes[0], True), (MODEL.prototypes[2], False)):
        found = belief_of(made, FACE, np.r_[np.zeros(6), posture])
        assert (found.closed > 0.5) == closed


def test_the_size_of_a_measure_adds_a_share_up_to_a_limit():
    added = Unknown(factor=0.0, least=0.3, share=0.4, most=1.2)
    small, at_limit, large = (float(added.deviation(np.zeros(()), h)) for h in (1.0, 3.0, 30.0))
    assert small == pytest.approx(0.5)
    assert at_limit == large == pytest.approx(np.hypot(0.3, 1.2))
    without = Unknown(factor=0.0, least=0.3, share=0.4)
    assert without.deviation(np.zeros(()), 30.0) == pytest.approx(np.hypot(0.3, 12.0))


def test_another_measure_that_agrees_leaves_more_belief_and_one_that_does_not_less():
    made, _ = told(400.0 * np.eye(N))
    found = belief_of(made, FACE, np.r_[np.zeros(6), MODEL.prototypes[0]])
    assert found.against(np.nan).aperture == found.aperture
    assert found.against(0.0).aperture < found.aperture < found.against(0.7).aperture
    doubted = found.against(3.0)
    assert doubted.aperture == pytest.approx(3 * found.aperture, rel=0.1)
    assert 0.5 < doubted.closed < found.closed
    assert doubted.width == found.width


def test_an_aperture_that_rests_on_landmarks_is_less_sure_the_farther_it_is_open():
    made, _ = told(400.0 * np.eye(N))
    shut, wide = (belief_of(made, FACE, np.r_[np.zeros(6), MODEL.prototypes[k]]) for k in (0, 2))
    assert shut.resting_on_landmarks(0.0).aperture == shut.aperture
    more = [
        found.resting_on_landmarks(1.0).aperture ** 2 - found.aperture**2 for found in (shut, wide)
    ]
    _, least, share, most = BELIEF.by_landmarks
    assert more == pytest.approx([least**2, least**2 + min(share * wide.gap, most) ** 2])
    half = wide.resting_on_landmarks(0.5).aperture ** 2 - wide.aperture**2
    assert half == pytest.approx(more[1] / 2)
    assert shut.resting_on_landmarks(1.0).closed < shut.closed
    assert shut.resting_on_landmarks(1.0).width == shut.width


def test_landmarks_share_is_the_weight_that_colours_lack():
    def share(alone=False, **colours):
        face = FACE.looking(colour=SimpleNamespace(**colours)) if colours else FACE
        return share_of_landmarks(face, alone=alone)

    assert share(poor=False, weight=0.3) == pytest.approx(0.7)
    assert share(poor=False, weight=0.3, alone=True) == share(alone=True) == 1.0
    assert share(poor=True, weight=0.3, alone=True) == share(poor=True, weight=0.3) == 0.0
    assert share() == 0.0


def test_evidence_without_curvature_gives_none():
    class Mute:
        def negative_log(self, candidates):
            return np.zeros(len(candidates))

    made, x = told(np.eye(N))
    assert belief_of(replace(made, terms={"mute": Mute()}), FACE, x) is None


def test_what_nothing_is_known_of_is_no_reason_to_fail():
    deviation = np.full(N, np.inf)
    nothing = Problem(BASE, FACE.blocks, {}, (GaussianPrior(np.zeros(N), deviation),))
    assert belief_of(nothing, FACE, np.zeros(N)) is None
    deviation[6:] = 1.0
    posture = replace(nothing, priors=(GaussianPrior(np.zeros(N), deviation),))
    found = belief_of(posture, FACE, np.zeros(N))
    assert np.isfinite(found.aperture)
    assert found.rotation.min() > 1.0


def test_a_value_that_is_not_in_nats_says_nothing_of_how_sure_it_is():
    made, x = told(np.eye(N))
    assert belief_of(replace(made, unit=1e-4), FACE, x) is None


def test_a_picture_that_says_nothing_leaves_what_the_priors_leave():
    made = problem(0)
    x = start(0, ALL)
    colour = made.terms[COLOUR]
    even = ClassMaps(np.full_like(colour.maps.maps, 0.5))
    flat = replace(made, terms={COLOUR: replace(colour, maps=even)})
    np.testing.assert_allclose(
        flat.information(x), replace(made, terms={}).information(x), atol=1e-9
    )


def test_lips_that_touch_are_no_surer_for_it():
    """The wall between them says nothing of the side on which they may part."""
    closed = np.r_[np.zeros(6), MODEL.prototypes[0]]
    contact = contact_prior(MODEL, np.zeros(MODEL.n_person))
    likely = GaussianPrior(np.zeros(N), np.ones(N))
    free = Problem(BASE, FACE.blocks, {}, (likely,))
    walled = Problem(BASE, FACE.blocks, {}, (likely, contact))
    assert np.abs(walled.newton(closed, 2)[2] - free.newton(closed, 2)[2]).max() > 1.0
    np.testing.assert_array_equal(walled.information(closed), free.information(closed))


def test_large_pixels_leave_more_open():
    made, x = told(400 * np.eye(N))
    fine = belief_of(made, FACE, x)
    near, far = fine.seen_in(0.5), fine.seen_in(5.0)
    assert near.aperture == pytest.approx(fine.aperture, rel=0.01)
    assert far.aperture > 1.5 > fine.aperture
    assert far.width > near.width
