"""The facet likelihood from buffers and from the fused sum; priors by hand."""

from __future__ import annotations

import numpy as np
import pytest
import shapes

from abs_engine.camera import Window
from abs_engine.compare.facets import FacetLikelihood, facet_score
from abs_engine.compare.prior import ContactPrior, GaussianPrior
from abs_engine.render.cpu import CpuRenderer
from abs_engine.scene import ClassMaps


@pytest.fixture(params=["whole", "crop"])
def likelihood(request):
    scene = shapes.ball()
    camera, window = shapes.view(64)
    if request.param == "crop":
        window = Window(20.5, 10, 30, 40, 1.7)
    width, height = window.drawn
    maps = ClassMaps(np.random.default_rng(0).uniform(0, 1, (5, height, width)))
    return FacetLikelihood(CpuRenderer(), scene, camera, window, maps, width * height, 250.0)


def test_the_score_of_buffers_is_the_fused_sum(likelihood):
    many = shapes.states(likelihood.scene, 5)
    given = likelihood.scene, many, likelihood.camera, likelihood.window
    scores = [facet_score(b, likelihood.maps.maps) for b in likelihood.renderer.draw(*given)]
    fused = likelihood.renderer.measure(*given, likelihood.maps)
    np.testing.assert_allclose(fused.total, scores, rtol=1e-6)
    expected = -250.0 * np.log(np.array(scores) / likelihood.pixels)
    np.testing.assert_allclose(likelihood.negative_log(many), expected, rtol=1e-6)
    assert np.ptp(expected) > 1


def test_the_score_by_hand():
    near = np.array([[-20, -20, 100], [20, -20, 100], [-20, 20, 100]], float)
    scene = shapes.triangles([near, near + np.array([0, 0, 50])], classes=[1, 2])
    camera, window = shapes.view(32)
    buffers = shapes.draw_one(CpuRenderer(), scene, camera, window)
    maps = np.zeros((3, 32, 32), np.float32)
    maps[0], maps[1], maps[2] = 100, 0.5, 0.25
    ones, twos = (buffers.class_id == 1).sum(), (buffers.class_id == 2).sum()
    assert ones > 100
    assert facet_score(buffers, maps) == 0.5 * ones + 0.25 * twos


def test_nothing_drawn_is_improbable_but_finite(likelihood):
    many = shapes.states(likelihood.scene, 1)
    many.translations[0, 0] += 5000
    assert likelihood.negative_log(many) == pytest.approx(-250 * np.log(1e-6))


def test_gaussian_prior_by_hand():
    prior = GaussianPrior(np.array([1.0, -2, 7]), np.array([0.5, 2, np.inf]))
    assert prior.negative_log(np.array([2.0, -2, 999])) == pytest.approx(0.5 * 4)
    assert prior.negative_log(np.array([1.0, 4, 0])) == pytest.approx(0.5 * 9)
    assert prior.negative_log(prior.mean) == 0


def test_contact_prior_by_hand():
    prior = ContactPrior(np.array([1.0, 0.2]), np.array([[1.0, 0], [0, -2]]), softness=0.5)
    assert prior.negative_log(np.zeros(2)) == 0
    assert prior.negative_log(np.array([-1.0, 0.1])) == 0  # they touch
    assert prior.negative_log(np.array([-3.0, 0])) == pytest.approx(0.5 * 16)
    assert prior.negative_log(np.array([-3.0, 0.6])) == pytest.approx(0.5 * (16 + 4))
