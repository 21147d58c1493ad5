"""Visemes by solid lips and flat ones."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.io.assets import load_speaker
from abs_engine.papers.basu1998.viseme_information import (
    YAWS,
    Discriminant,
    transmitted,
    turned,
    viseme_information,
)


def test_what_is_transmitted_lies_between_nothing_and_the_entropy():
    true = np.repeat(np.arange(4), 1000)
    assert transmitted(true, true) == pytest.approx(2.0)
    assert transmitted(true, (true + 1) % 4) == pytest.approx(2.0)  # wrong, but told apart
    assert transmitted(true, true // 2) == pytest.approx(1.0)
    assert transmitted(true, np.random.default_rng(0).permutation(true)) < 0.01


def test_the_discriminant_weighs_by_the_covariance():
    rng = np.random.default_rng(0)
    classes = rng.integers(2, size=2000)
    common = 5 * rng.normal(size=2000)  # in both features alike: says nothing
    features = np.stack([common + classes, common], axis=1) + 0.1 * rng.normal(size=(2000, 2))
    answers = Discriminant.of(features[:1000], classes[:1000])(features[1000:])
    assert (answers == classes[1000:]).mean() > 0.99


def test_a_head_that_turns_to_its_left_shows_depth_to_the_right():
    front = turned(np.array([[0.0, 0.0, 1.0], [1.0, 2.0, 0.0]]), 0)
    aside = turned(np.array([[0.0, 0.0, 1.0], [1.0, 2.0, 0.0]]), 90)
    np.testing.assert_allclose(front, [[0, 0], [1, 2]], atol=1e-12)
    np.testing.assert_allclose(aside, [[1, 0], [0, 2]], atol=1e-12)


def test_solid_lips_are_read_from_every_side_and_flat_ones_from_the_front():
    found = viseme_information(load_speaker(), 0, syllables=12)
    solid, flat, told = (found[k]["error_rate"] for k in ("solid", "flat", "flat_each_yaw"))
    assert found["samples"] == 6 * 24
    assert len(solid) == len(flat) == len(YAWS)
    assert max(solid) < 0.45
    assert flat[-1] > max(solid) + 0.1
    assert max(told) < flat[-1]
    assert all(0 <= b <= found["bits_at_most"] for k in ("solid", "flat") for b in found[k]["bits"])
