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
    together = Mixtures(MANY).densities(SAMPLES.astype(np.float32))
    assert together.dtype == np.float32
    for one, found in zip(MANY, together, strict=True):
        np.testing.assert_allclose(found, one.density(SAMPLES), rtol=1e-3, atol=1e-4 * one.peak)


def with_others(weight):
    """The samples with a weight, and 50 elsewhere that have none."""
    others = np.random.default_rng(2).uniform(2.0, 3.0, (50, 3))
    return np.vstack([SAMPLES, others]), np.r_[weight, np.zeros(50)]


LEARNING = [
    lambda *given: fit_mixture(*given, 1), lambda *given: fit_mixture(*given, 3),
    MANY[0].updated, lambda *given: MANY[0].anchored(*given, MANY[0], 20.0),
]  # fmt: skip


@pytest.mark.parametrize("learn", LEARNING, ids=["one", "several", "updated", "anchored"])
def test_samples_without_a_weight_teach_nothing(learn):
    weight = np.random.default_rng(1).uniform(0.2, 1.0, len(SAMPLES))
    alone, both = learn(SAMPLES, weight), learn(*with_others(weight))
    np.testing.assert_allclose(both.means, alone.means)
    np.testing.assert_allclose(both.covariances, alone.covariances)
