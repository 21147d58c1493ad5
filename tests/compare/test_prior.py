"""Priors over shapes: one Gaussian, and a mixture about what was seen."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.compare.mixture_prior import MixturePrior
from abs_engine.compare.prior import ContactPrior, GaussianPrior, PenaltyPrior
from abs_engine.core.errors import ParameterError
from abs_engine.face.penalty import ImprobablePenalty

RNG = np.random.default_rng(3)
SEEN = np.column_stack([RNG.choice([-1.0, 1.0], 40), RNG.normal(size=40)])
SEEN = (SEEN - SEEN.mean(axis=0)) / SEEN.std(axis=0)
GAUSSIAN = GaussianPrior(np.array([0.5, 0, 0]), np.array([2.0, 1, 1]))


def mixture(width: float) -> MixturePrior:
    """Over one Gaussian parameter and two of a shape."""
    return MixturePrior(GAUSSIAN, SEEN, width)


def test_a_width_of_one_leaves_the_gaussian():
    x, y = np.array([1.0, -2, 0.5]), np.array([0.0, 0.3, 1])
    whole = mixture(1.0)
    away = whole.negative_log(x) - whole.negative_log(y)
    assert away == pytest.approx(GAUSSIAN.negative_log(x) - GAUSSIAN.negative_log(y))


@pytest.mark.parametrize("width", [0.4, 0.7])
def test_mean_and_variance_stay_those_of_the_gaussian(width):
    """By summing the density over a grid: the shapes have mean 0 and variance 1."""
    axis = np.linspace(-5, 5, 101)
    grid = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
    prior = mixture(width)
    density = np.exp([-prior.negative_log(np.r_[0.5, p]) for p in grid])
    density /= density.sum()
    np.testing.assert_allclose(density @ grid, 0, atol=1e-3)
    np.testing.assert_allclose(density @ grid**2, 1, atol=0.01)


def test_what_lies_between_shapes_that_were_seen_is_less_probable():
    """Most probable for one Gaussian is the mean, at which no shape was seen."""
    at, between = np.array([0.5, 0.7, 0]), np.array([0.5, 0, 0])
    assert GAUSSIAN.negative_log(between) < GAUSSIAN.negative_log(at)
    assert mixture(0.5).negative_log(at) < mixture(0.5).negative_log(between) - 0.2


PENALTY = PenaltyPrior(
    ImprobablePenalty(np.array([0.5, -0.2]), np.array([[1.2, 0], [0.4, 0.8]])), 3.0, slice(1, 3)
)
CONTACT = ContactPrior(np.array([-2.0, 2.0, -1.5]), RNG.normal(size=(3, 3)) / 5, softness=0.5)


@pytest.mark.parametrize(
    "prior",
    [GAUSSIAN, mixture(0.5), CONTACT, PENALTY],
    ids=["gaussian", "mixture", "contact", "penalty"],
)
def test_slopes_are_those_of_differences(prior):
    x, small = np.array([1.2, -0.4, 0.9]), 1e-5
    found = [
        (prior.negative_log(x + d) - prior.negative_log(x - d)) / (2 * small)
        for d in small * np.eye(3)
    ]
    np.testing.assert_allclose(prior.slope(x), found, rtol=1e-6)


def test_the_curvature_of_a_penalty_at_its_mean_is_that_of_its_slope():
    x, small = np.array([1.2, 0.5, -0.2]), 1e-3
    found = [(PENALTY.slope(x + d) - PENALTY.slope(x - d)) / (2 * small) for d in small * np.eye(3)]
    np.testing.assert_allclose(PENALTY.curvature(x), found, rtol=1e-3, atol=1e-4)


def test_far_away_nothing_overflows():
    far = np.array([0.5, 300.0, -200])
    for prior in (mixture(0.4), PENALTY):
        assert np.isfinite(prior.negative_log(far))
        assert np.isfinite(prior.slope(far)).all()


@pytest.mark.parametrize("width", [0.0, -0.5, 1.001, np.nan, np.inf])
def test_a_width_that_is_none_is_refused(width):
    with pytest.raises(ParameterError, match="the mixture's width is"):
        mixture(width)


@pytest.mark.parametrize(
    ("seen", "said"),
    [
        (SEEN[:0], "shape"), (SEEN[0], "shape"), (SEEN[None], "shape"), (SEEN[:, :0], "shape"),
        (np.zeros((3, 4)), "shape"), (np.where(SEEN > 1, np.nan, SEEN), "not finite"),
        (np.where(SEEN > 1, np.inf, SEEN), "not finite"),
    ],
    ids=["none", "1d", "3d", "no columns", "wide", "nan", "inf"],
)  # fmt: skip
def test_shapes_that_are_none_are_refused(seen, said):
    with pytest.raises(ParameterError, match=said):
        MixturePrior(GAUSSIAN, seen, 0.5)


def test_of_shrunk_shapes_the_variance_is_below_the_gaussian_s():
    """width^2 + (1 - width^2) times theirs."""
    axis = np.linspace(-5, 5, 101)
    grid = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
    prior = MixturePrior(GAUSSIAN, 0.9 * SEEN, 0.6)
    density = np.exp([-prior.negative_log(np.r_[0.5, p]) for p in grid])
    density /= density.sum()
    np.testing.assert_allclose(density @ grid**2, 0.36 + 0.64 * 0.81, atol=0.01)


@pytest.mark.parametrize("width", [0.4, 0.7, 1.0])
def test_squared_roots_add_up_to_the_value(width):
    rows = np.array([[1.0, -2, 0.5], [0.0, 0.3, 1], [0.5, *SEEN[0]]])
    roots = mixture(width).roots(rows)
    np.testing.assert_allclose((roots**2).sum(axis=1), mixture(width).negative_logs(rows))
