"""What the landmark network's errors have in common comes back from errors that were made up."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from drawn import correspondence

from abs_engine.core.errors import ModelFormatError
from abs_engine.io.arrays import check_arrays
from abs_engine.tracking.detection.landmarks import COUNT, SeenRays
from abs_engine.tracking.landmark.landmark_noise import LAYOUT, LandmarkNoise, learn_noise, seen_off


def made(seed=0, people=60, views=8):
    """Errors of known make: a bias, one factor of people and one of frames, and a little more."""
    rng = np.random.default_rng(seed)
    bias = rng.normal(0, 1, (COUNT, 3))
    person, frame = (rng.normal(0, 2, (COUNT, 3)) for _ in range(2))
    who = np.repeat(np.arange(people), views)
    off = bias + rng.normal(size=people)[who, None, None] * person
    off = off + rng.normal(size=len(who))[:, None, None] * frame
    return off + rng.normal(0, 0.3, off.shape), who, bias, person, frame


def alike(one, other):
    """Cosine between two fields."""
    return abs(float((one * other).sum() / np.linalg.norm(one) / np.linalg.norm(other)))


def test_bias_and_factors_are_told_apart():
    off, who, bias, person, frame = made()
    found = learn_noise(off, who)
    assert np.sqrt(np.mean((found.bias - bias) ** 2)) < 0.6  # 60 people
    assert alike(found.between[0], person) > 0.97
    assert alike(found.within[0], frame) > 0.97
    for factor, true in ((found.between[0], person), (found.within[0], frame)):
        assert np.linalg.norm(factor) == pytest.approx(np.linalg.norm(true), rel=0.25)
    assert np.linalg.norm(found.within[1]) < 0.2 * np.linalg.norm(found.within[0])


def test_no_direction_is_trusted_without_measure():
    off, who, *_ = made()
    found = learn_noise(0.01 * off, who)
    assert found.deviation.min() >= 1.0
    assert found.person_deviation.min() >= 1.0


def test_the_whole_variance_is_that_of_errors_of_many_frames():
    rng = np.random.default_rng(4)
    bias, deviation, person = (rng.uniform(0.5, 2, (2, 3)) for _ in range(3))
    within = rng.normal(size=(2, 2, 3))
    noise = LandmarkNoise(bias, np.zeros((0, 2, 3)), within, deviation, person)
    off = np.tensordot(rng.normal(size=(20_000, 2)), within, 1) + bias
    off += np.hypot(deviation, person) * rng.normal(size=off.shape)
    np.testing.assert_allclose(noise.whole, off.var(axis=0), rtol=0.05)


def test_errors_are_along_the_eyes_and_down_the_face_of_a_head_that_leans():
    rng = np.random.default_rng(5)
    there = np.column_stack([rng.normal(0, 50, (COUNT, 2)), np.full(COUNT, 700.0)])
    axes = np.array([[0.8, 0.6], [-0.6, 0.8]])
    off = rng.normal(size=(COUNT, 3))
    rays = (there[:, :2] + off[:, :2] @ axes) / 700
    found = seen_off(there, SeenRays(rays, 1 + off[:, 2] / 700, axes, np.ones(COUNT), 0.001))
    off[:, 2] -= off[:, 2].mean()  # how far away a face is, no network sees
    np.testing.assert_allclose(found, off, atol=1e-9)


def test_of_a_known_person_its_error_is_no_noise():
    noise = correspondence().noise
    weights = np.random.default_rng(1).normal(size=len(noise.between))
    own = noise.person(weights)
    np.testing.assert_allclose(own.bias - noise.bias, np.tensordot(weights, noise.between, 1))
    assert len(own.between) == 0
    assert (own.variance < noise.variance).all()


def test_it_is_kept_in_a_file():
    noise = correspondence().noise
    again = LandmarkNoise.of_arrays(check_arrays(Path(), noise.arrays(), LAYOUT, ""))
    for name, value in vars(noise).items():
        np.testing.assert_allclose(getattr(again, name), value, atol=2e-2, err_msg=name)


@pytest.mark.parametrize(
    "change",
    [
        {"noise_bias": np.zeros((3, 3))},
        {"noise_bias": np.full((468, 3), np.nan)},
        {"noise_between": np.zeros((468, 3))},
        {"noise_deviation": np.zeros((468, 3))},
    ],
)
def test_what_is_of_other_landmarks_is_refused(change):
    with pytest.raises(ModelFormatError, match="noise_"):
        check_arrays(Path("f"), correspondence().noise.arrays() | change, LAYOUT, "again")


def test_one_person_alone_has_no_error_of_its_own():
    off, who, *_ = made(people=1, views=10)
    found = learn_noise(off, who)
    assert len(found.between) == 0
    assert np.isfinite(found.deviation).all()
