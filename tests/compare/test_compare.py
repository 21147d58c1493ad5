"""The facet likelihood from buffers and from the fused sum; priors by hand."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
import shapes

from abs_engine.compare.facets import FacetLikelihood
from abs_engine.compare.prior import ContactPrior, GaussianPrior
from abs_engine.compare.sums import buffer_sums
from abs_engine.core.camera import Window
from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import ClassMaps
from abs_engine.render.cpu import CpuRenderer


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
    scores = buffer_sums(likelihood.renderer.draw(*given), likelihood.maps).total
    fused = likelihood.renderer.measure(*given, likelihood.maps)
    np.testing.assert_allclose(fused.total, scores, rtol=1e-6)
    expected = -250.0 * np.log(scores / likelihood.pixels)
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
    assert buffer_sums([buffers], ClassMaps(maps)).total[0] == 0.5 * ones + 0.25 * twos


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


# ---- what is left free ---------------------------------------------------------------------------


def bare(renderer=None):
    """A ball before a background, with random maps of its classes and of what is left free."""
    scene = shapes.ball()
    camera, window = shapes.view(64)
    rng = np.random.default_rng(2)
    maps = ClassMaps(rng.uniform(0, 1, (5, 64, 64)))
    outside = rng.uniform(0, 1, (64, 64)).astype(np.float32)
    drawn_by = renderer or CpuRenderer()
    return FacetLikelihood(drawn_by, scene, camera, window, maps, 64 * 64, 250.0, outside)


def test_pixels_that_are_left_free_count():
    """By hand from the buffers: the class's map where a facet is drawn, `outside` elsewhere."""
    free = bare()
    many = shapes.states(free.scene, 4)
    drawn = free.renderer.draw(free.scene, many, free.camera, free.window)
    scores = buffer_sums(drawn, free.maps).total + [free.outside[~b.covered].sum() for b in drawn]
    expected = -250 * np.log(scores / free.pixels)
    np.testing.assert_allclose(free.negative_log(many), expected, rtol=1e-5)
    assert min((~b.covered).sum() for b in drawn) > 300


@pytest.mark.parametrize("what", ["all compared", "some left free"])
def test_one_sample_for_each_facet_is_another_rule_of_the_same_integral(what, likelihood):
    """By hand from the buffers: visible area times the map at the centre of what is seen."""
    exact = likelihood if what == "all compared" else bare()
    sample = replace(exact, rule="sample")
    many = shapes.states(exact.scene, 3)
    drawn = exact.renderer.draw(exact.scene, many, exact.camera, exact.window)
    expected = []
    for buffers in drawn:
        score = 0.0 if exact.outside is None else exact.outside.sum(dtype=np.float64)
        for facet in np.unique(buffers.facet_id[buffers.covered]) - 1:
            rows, columns = np.nonzero(buffers.facet_id == facet + 1)
            at = np.float32([[columns.mean()]]), np.float32([[rows.mean()]])
            planes = [exact.maps.maps[exact.scene.facet_class[facet]]]
            planes += [] if exact.outside is None else [-exact.outside]
            score += len(rows) * sum(
                float(cv2.remap(p.astype(np.float32), *at, cv2.INTER_LINEAR)[0, 0]) for p in planes
            )
        expected.append(-250 * np.log(score / exact.pixels))
    np.testing.assert_allclose(sample.negative_log(many), expected, rtol=1e-4)
    assert np.abs(sample.negative_log(many) - exact.negative_log(many)).max() > 1e-3


def test_one_sample_does_not_stand_for_pixels_that_are_not_compared():
    """Else what a facet at the edge shows within would be counted without, too."""
    whole = bare()
    compared = np.hypot(*(np.mgrid[:64, :64] - 31.5)) < 12
    maps = ClassMaps(np.where(compared, 1.0, 0.0) * np.ones((5, 1, 1)))
    inside = replace(whole, maps=maps, outside=np.zeros((64, 64), np.float32), compared=compared)
    inside = replace(inside, pixels=int(compared.sum()))
    many = shapes.states(inside.scene, 3)
    exact = inside.negative_log(many)
    np.testing.assert_allclose(exact, 0, atol=1e-3)  # all of them are explained
    sampled = replace(inside, rule="sample").negative_log(many)
    assert sampled.min() >= 0
    assert sampled.max() < 40  # a sample at the edge is mixed with the 0 beside it
    assert replace(inside, rule="sample", compared=None).negative_log(many).min() < -1


@pytest.mark.parametrize("value", [0.3, 1.0])
def test_both_rules_agree_where_maps_are_even(value):
    even = replace(bare(), maps=ClassMaps(np.full((5, 64, 64), value)))
    even = replace(even, outside=np.full((64, 64), 0.4, np.float32))
    many = shapes.states(even.scene, 3)
    np.testing.assert_allclose(
        replace(even, rule="sample").negative_log(many), even.negative_log(many), rtol=1e-5
    )


def test_an_unknown_rule_of_the_integral_is_named():
    with pytest.raises(ParameterError, match="the rule 'three'; choose exact or sample"):
        replace(bare(), rule="three")


def test_growing_over_the_background_costs_only_where_free_pixels_count():
    """A nearer ball covers background, which its classes suit by little."""
    free = bare()
    still = shapes.states(free.scene, 1)
    nearer = replace(still, translations=still.translations * [1, 1, 0.9])
    seen, grown = (
        free.renderer.draw(free.scene, c, free.camera, free.window)[0].covered
        for c in (still, nearer)
    )
    assert (grown & ~seen).sum() > 100
    maps = ClassMaps(np.where(seen, 0.9, 0.2) * np.ones((5, 1, 1)))
    free = replace(free, maps=maps, outside=np.where(seen, 0.0, 0.8).astype(np.float32))
    blind = replace(free, outside=None)
    for likelihood, better in ((free, still), (blind, nearer)):
        worse = nearer if better is still else still
        assert likelihood.negative_log(better)[0] < likelihood.negative_log(worse)[0] - 1


def test_without_what_lies_outside_the_score_is_the_drawn_pixels_alone():
    blind = replace(bare(), outside=None)
    many = shapes.states(blind.scene, 3)
    sums = blind.renderer.measure(blind.scene, many, blind.camera, blind.window, blind.maps)
    expected = -250 * np.log(sums.total / blind.pixels)
    np.testing.assert_allclose(blind.negative_log(many), expected)
    even = replace(blind, outside=np.zeros((64, 64), np.float32))
    np.testing.assert_allclose(even.negative_log(many), expected, rtol=1e-5)


def test_nothing_drawn_is_worth_what_lies_outside():
    free = bare()
    many = shapes.states(free.scene, 1)
    many.translations[0, 0] += 5000
    expected = -250 * np.log(free.outside.mean())
    assert free.negative_log(many)[0] == pytest.approx(expected, rel=1e-5)


@pytest.mark.gl
def test_free_pixels_count_alike_in_opengl(renderer):
    free, oracle = bare(renderer), bare()
    many = shapes.states(free.scene, 8)
    np.testing.assert_allclose(free.negative_log(many), oracle.negative_log(many), rtol=2e-4)
