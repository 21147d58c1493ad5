"""Mixtures: many at once in single precision, and samples without a weight."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.face.appearance.mixture import Mixture, Mixtures, fit_mixture


def mixture(count, seed):
    random = np.random.default_rng(seed)
    roots = random.normal(0, 0.05, (count, 3, 3))
    weights = random.uniform(0.5, 1.0, count)
    covariances = roots @ roots.transpose(0, 2, 1) + 1e-4 * np.eye(3)
    return Mixture(weights / weights.sum(), random.uniform(0, 0.5, (count, 3)), covariances)


MANY = tuple(mixture(count, seed) for seed, count in enumerate((3, 1, 4)))
SAMPLES = np.random.default_rng(9).uniform(-0.1, 0.6, (400, 3))


def test_mixtures_evaluated_together_are_those_evaluated_alone():
    together = Mixtures(MANY)
    parts = together.components(SAMPLES.astype(np.float32))
    assert parts.dtype == np.float32
    for k, (one, found) in enumerate(zip(MANY, together.added(parts), strict=True)):
        peak = one.peak
        np.testing.assert_allclose(found, one.density(SAMPLES), rtol=1e-3, atol=1e-4 * peak)
        each = parts[together.of(k)].T
        np.testing.assert_allclose(each, one.densities(SAMPLES), rtol=1e-3, atol=1e-4 * peak)


@pytest.mark.parametrize("most", [1, 3])
def test_samples_without_a_weight_teach_nothing(most):
    weight = np.random.default_rng(1).uniform(0.2, 1.0, len(SAMPLES))
    beside = np.r_[weight, np.zeros(50)]
    more = np.vstack([SAMPLES, np.random.default_rng(2).uniform(2.0, 3.0, (50, 3))])
    alone, both = fit_mixture(SAMPLES, weight, most), fit_mixture(more, beside, most)
    np.testing.assert_allclose(both.means, alone.means)
    np.testing.assert_allclose(both.covariances, alone.covariances)
    own = [m.anchored(*given, MANY[0], 20.0) for m, given in (
        (MANY[0], (SAMPLES, weight)), (MANY[0], (more, beside)),
    )]  # fmt: skip
    np.testing.assert_allclose(own[1].means, own[0].means)
