"""Linear shapes: principal components in the metric that was asked for, and the mouth's own."""

from __future__ import annotations

import json

import numpy as np
import pytest

from abs_engine.core.errors import InputFileError, ModelFormatError, ParameterError
from abs_engine.face.settings.shape import SHAPE
from abs_engine.face.shape.linear import principal_shapes
from abs_engine.face.shape.mouth import SIDEWAYS, mouth_shape, mouth_units, sample_postures
from abs_engine.face.shape.population import average_person
from abs_engine.face.shape.postures import Postures, recorded_postures
from abs_engine.face.shape.scanned_units import unit_differences
from abs_engine.io.assets import load_speaker

N, V = 6, 40


@pytest.fixture
def toy():
    """Neutral, generators, samples of correlated weights, importance."""
    rng = np.random.default_rng(0)
    samples = rng.normal(0, 1, (500, N)) @ rng.normal(0, 1, (N, N)) + rng.normal(0, 1, N)
    neutral = rng.normal(0, 30, (V, 3)).astype(np.float32)
    generators = rng.normal(0, 1, (N, V, 3)).astype(np.float32)
    return neutral, generators, samples, rng.uniform(0, 3, V)


def shapes_of(neutral, generators, samples):
    return neutral + np.tensordot(samples, generators, 1)


def test_the_mean_is_that_of_the_shapes(toy):
    neutral, generators, samples, importance = toy
    model = principal_shapes(neutral, generators, Postures.of(samples), 3, importance)
    np.testing.assert_allclose(model.mean, shapes_of(*toy[:3]).mean(axis=0), atol=1e-4)
    np.testing.assert_allclose(model.offset, samples.mean(axis=0))


def test_modes_are_those_of_the_vertices_covariance(toy):
    """The detour over the generators' space gives what the plain way gives."""
    neutral, generators, samples, importance = toy
    model = principal_shapes(neutral, generators, Postures.of(samples), N, importance)
    scale = np.repeat(np.sqrt(importance), 3)
    flat = shapes_of(neutral, generators, samples).reshape(len(samples), -1) * scale
    values = np.linalg.eigvalsh(np.cov(flat.T))[::-1][:N]
    weighted = model.modes.reshape(N, -1) * scale
    gram = weighted @ weighted.T
    np.testing.assert_allclose(np.diag(gram), values, rtol=1e-4)
    assert np.abs(gram - np.diag(np.diag(gram))).max() < 1e-4 * values[0]
    np.testing.assert_allclose(model.variance, values / values.sum(), rtol=1e-4)
    assert (np.diff(model.variance) <= 0).all()
    assert model.variance.sum() == pytest.approx(1)


def test_parameters_of_the_samples_have_unit_variance(toy):
    neutral, generators, samples, importance = toy
    model = principal_shapes(neutral, generators, Postures.of(samples), N, importance)
    parameters = np.linalg.solve(model.mixing.T, (samples - model.offset).T).T
    np.testing.assert_allclose(np.cov(parameters.T), np.eye(N), atol=1e-6)


def test_generators_make_the_same_vertices_as_the_modes(toy):
    neutral, generators, samples, importance = toy
    model = principal_shapes(neutral, generators, Postures.of(samples), 4, importance)
    parameters = np.random.default_rng(1).normal(0, 1, (3, 4))
    by_modes = model.mean + np.tensordot(parameters, model.modes, 1)
    by_generators = shapes_of(neutral, generators, model.offset + parameters @ model.mixing)
    np.testing.assert_allclose(by_modes, by_generators, atol=1e-3)


def test_more_modes_than_the_samples_span(toy):
    neutral, generators, samples, importance = toy
    flat = samples.copy()
    flat[:, -2:] = 0.5
    with pytest.raises(ParameterError, match="5 modes asked for, the postures span 4"):
        principal_shapes(neutral, generators, Postures.of(flat), 5, importance)


@pytest.fixture(scope="module")
def speaker():
    return load_speaker()


@pytest.fixture(scope="module")
def mouth(speaker):
    return mouth_shape(speaker, speaker.vertices, 10)


def test_postures_are_plausible():
    names = mouth_units()
    postures = sample_postures(500, seed=3)
    assert postures.shape == (500, len(names))
    assert postures.min() >= 0
    assert postures.max() < 1.1
    jaw, close = postures[:, names.index("jawOpen")], postures[:, names.index("mouthClose")]
    assert jaw.max() < SHAPE.widest_jaw + 0.4
    assert (close <= jaw + 1e-12).all()
    np.testing.assert_array_equal(postures, sample_postures(500, seed=3))


def test_pooled_moments_are_those_of_both_kinds_together():
    rng = np.random.default_rng(0)
    one, other = rng.normal(0, 1, (500, 3)), rng.normal(2, 3, (1500, 3))
    pooled = Postures.of(one).pooled(Postures.of(other), 0.25)
    together = np.concatenate([one, other])
    np.testing.assert_allclose(pooled.mean, together.mean(axis=0))
    np.testing.assert_allclose(pooled.covariance, np.cov(together.T, bias=True), rtol=5e-3)


def test_recorded_postures_prefer_no_side_and_follow_the_names_asked_for():
    names = ("jawOpen", "mouthSmileLeft", "mouthSmileRight")
    told, turned = recorded_postures(names), recorded_postures(names[::-1])
    assert told.mean[1] == told.mean[2]
    assert told.covariance[0, 1] == told.covariance[0, 2]
    assert told.covariance[1, 2] > 0.9 * told.covariance[1, 1]  # people smile with both sides
    np.testing.assert_array_equal(told.covariance, turned.covariance[::-1, ::-1])


@pytest.mark.parametrize(
    ("change", "error", "said"),
    [
        ({"version": 9}, ModelFormatError, "another format or version"),
        ({"mean": [0.0]}, ModelFormatError, "mean"),
        ({"covariance": [[1.0, float("nan")], [0.0, 1.0]]}, InputFileError, "no moments"),
        ({"unit_names": ["jawOpen", "brow"]}, ModelFormatError, "says nothing of mouthClose"),
        ({"mean": None}, ModelFormatError, "mean"),
    ],
)
def test_a_file_of_postures_that_is_none_is_refused(tmp_path, change, error, said):
    names = ["jawOpen", "mouthClose"]
    good = {"format": "abs_engine.postures", "version": 1, "unit_names": names,
            "mean": [0.1, 0.2], "covariance": [[1.0, 0.1], [0.1, 1.0]]}  # fmt: skip
    path = tmp_path / "postures.json"
    path.write_text(json.dumps(good))
    assert recorded_postures(names, path).mean.tolist() == [0.1, 0.2]
    path.write_text(json.dumps(good | change))
    with pytest.raises(error, match=said):
        recorded_postures(names, path)


def test_modes_are_orthogonal_over_the_lips_metric(speaker, mouth):
    """Lips count five times, what lies inside of the mouth not at all."""
    weight = np.zeros(len(speaker.vertices))
    for names, value in ((("skin",), 1.0), (("upper_lip", "lower_lip"), 5.0)):
        ids = [speaker.class_id(n) for n in names]
        weight[speaker.faces[np.isin(speaker.facet_class, ids)]] = value
    flat = mouth.modes.reshape(10, -1).astype(float)
    gram = flat * np.repeat(weight, 3) @ flat.T
    size = np.sqrt(np.diag(gram))
    assert np.abs(gram / np.outer(size, size) - np.eye(10)).max() < 1e-3
    assert (np.diff(size) <= 0).all()


def test_ten_modes_hold_a_posture_that_was_not_trained_on(speaker, mouth):
    units = speaker.unit_matrix(mouth_units())
    lips = np.unique(speaker.faces[np.isin(speaker.facet_class, (2, 3))])
    matrix = mouth.modes[:, lips].reshape(10, -1).T.astype(float)
    errors, sizes = [], []
    for posture in sample_postures(40, seed=77):
        moved = speaker.vertices[lips] + np.tensordot(posture, units[:, lips], 1)
        offset = (moved - mouth.mean[lips]).ravel()
        rest = offset - matrix @ np.linalg.lstsq(matrix, offset, rcond=None)[0]
        errors.append(np.sqrt(3 * np.mean(rest**2)))
        sizes.append(np.sqrt(3 * np.mean(offset**2)))
    assert np.sqrt(np.mean(np.square(errors))) < 0.45  # mm
    assert np.sqrt(np.mean(np.square(sizes))) > 2.5


def test_generators_that_a_share_of_the_postures_has_again_have_the_moments_of_samples():
    rng = np.random.default_rng(4)
    weights = rng.normal(size=(200_000, 3)) @ rng.normal(size=(3, 3)) + [1.0, 2.0, -1.0]
    again = rng.random((len(weights), 1)) < 0.3
    sampled = Postures.of(np.c_[weights, weights * again])
    found = Postures.of(weights).partly_again(0.3)
    np.testing.assert_allclose(found.mean, sampled.mean, atol=0.02)
    np.testing.assert_allclose(found.covariance, sampled.covariance, atol=0.1)


def test_postures_whose_weights_are_scaled_have_the_moments_of_scaled_samples():
    weights, factors = np.random.default_rng(5).normal(1.0, 2.0, (400, 3)), np.array([1.0, 0.5, 0])
    found, sampled = Postures.of(weights).scaled(factors), Postures.of(weights * factors)
    np.testing.assert_allclose(found.mean, sampled.mean)
    np.testing.assert_allclose(found.covariance, sampled.covariance)


def test_lips_of_anybody_move_as_those_of_scans_in_depth_and_across_in_a_share_of_postures():
    speaker, names = average_person(), mouth_units()
    lips = speaker.lip_ring
    shape = mouth_shape(speaker, speaker.vertices, 20, anybody=True)
    moments = recorded_postures(names).pooled(Postures.of(sample_postures(4000, 0)), SHAPE.recorded)
    rng = np.random.default_rng(5)
    weights = rng.multivariate_normal(moments.mean, moments.covariance, 20_000)
    weights[:, [names.index(name) for name in SIDEWAYS]] *= SHAPE.sideways
    differences = unit_differences(names)[:, lips]
    deep = speaker.unit_matrix(names)[:, lips]
    deep[..., 2] += differences[..., 2]
    own = deep.reshape(len(names), -1)
    scanned = (speaker.unit_matrix(names)[:, lips] + differences).reshape(len(names), -1)
    by_scans = rng.random((len(weights), 1)) < SHAPE.scanned_units
    moved = np.where(by_scans, weights @ scanned, weights @ own)
    modes = shape.modes[:, lips].reshape(20, -1)
    np.testing.assert_allclose((modes**2).sum(axis=0), moved.var(axis=0), rtol=0.1, atol=0.05)
    mean = (shape.mean - speaker.vertices)[lips].ravel()
    np.testing.assert_allclose(mean, moved.mean(axis=0), atol=0.15)
