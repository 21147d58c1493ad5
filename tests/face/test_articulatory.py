"""Guided principal components: what was put in comes out, in the order that was asked for."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from made_visemes import GROUPS, NAMES, directions, visemes

from abs_engine.core.errors import (
    InputFileError,
    ModelFormatError,
    OutputError,
    ParameterError,
    TooFewPointsError,
)
from abs_engine.face.shape.articulatory import GuidedPCA
from abs_engine.face.shape.articulatory_model import load_articulatory
from abs_engine.face.shape.predictors import PAPER_PREDICTORS, Predictor
from abs_engine.learn.articulatory import dense_units

JAW = Predictor("jaw", ("jaw",), "y", "-y")
LIPS = Predictor("lips", ("lips",), "z", "+z")


def fitted(points: np.ndarray, *predictors: Predictor, missing: str = "refuse") -> GuidedPCA:
    return GuidedPCA(NAMES, GROUPS, predictors or (JAW, LIPS), missing).fit(points)


def test_known_directions_and_parameters_come_back():
    alpha, points = visemes()
    found = fitted(points)
    np.testing.assert_allclose(found.components_, directions(), atol=1e-9)
    np.testing.assert_allclose(found.mean_, points.mean(axis=0), atol=1e-12)
    np.testing.assert_allclose(found.scores_, alpha, atol=1e-9)
    np.testing.assert_allclose(found.transform(points), alpha, atol=1e-9)
    np.testing.assert_allclose(found.inverse_transform(alpha), points, atol=1e-9)
    assert found.model_.held == pytest.approx(1.0)


def test_flat_visemes_are_the_same():
    _, points = visemes()
    flat = fitted(points.reshape(len(points), -1))
    np.testing.assert_array_equal(flat.components_, fitted(points).components_)


def test_the_sign_is_the_one_that_is_asked_for():
    _, points = visemes()
    up = fitted(points, replace(JAW, positive="+y"))
    np.testing.assert_allclose(up.components_[0], -directions()[0], atol=1e-9)


def test_order_matters():
    """A parameter that comes first takes along what is correlated with it."""
    _, points = visemes(noise=0.2)
    height = Predictor("height", ("lips",), "y", "-y")
    first, second = fitted(points, JAW, height), fitted(points, height, JAW)
    assert first.explained_variance_ratio_[1] < 0.05  # the jaw has taken the lips along
    assert second.explained_variance_ratio_[1] < 0.05  # the lips have taken the jaw along
    np.testing.assert_allclose(first.components_[0], directions()[0], atol=0.2)
    np.testing.assert_allclose(second.components_[0], directions()[0], atol=0.2)
    assert np.corrcoef(first.scores_[:, 0], second.scores_[:, 0])[0, 1] > 0.98


def test_shares_add_up_to_what_is_explained():
    _, points = visemes(noise=0.5)
    found = fitted(points)
    left = points - found.mean_ - np.tensordot(found.scores_, found.components_, 1)
    total = ((points - points.mean(axis=0)) ** 2).sum()
    assert found.explained_variance_ratio_.sum() == pytest.approx(1 - (left**2).sum() / total)
    assert 0 < found.model_.held < 1


def test_the_residual_is_orthogonal_to_every_parameter_and_they_to_each_other():
    _, points = visemes(noise=0.5)
    found = fitted(points)
    left = points - found.mean_ - np.tensordot(found.scores_, found.components_, 1)
    np.testing.assert_allclose(np.tensordot(found.scores_.T, left, 1), 0, atol=1e-9)
    np.testing.assert_allclose(np.cov(found.scores_.T), np.eye(2), atol=1e-12)


def test_direct_inversion_is_least_squares_over_the_points_that_are_there():
    _, points = visemes(noise=0.5)
    model = fitted(points).model_
    seen = points[3].copy()
    seen[[1, 6]] = np.nan
    alpha = model.invert(seen)
    keep = np.isfinite(seen[:, 0])
    missed = (seen - model.points(alpha))[keep]
    np.testing.assert_allclose(np.tensordot(model.modes[:, keep], missed, 2), 0, atol=1e-9)
    errors = model.errors(seen)
    assert np.isnan(errors[[1, 6]]).all()
    np.testing.assert_allclose(errors[keep], np.linalg.norm(missed, axis=1))


def test_habits_of_scikit_learn():
    estimator = GuidedPCA(NAMES, GROUPS, (JAW,))
    for early in (estimator.transform, estimator.inverse_transform):
        with pytest.raises(ParameterError, match="nothing was learned yet; call fit first"):
            early(np.zeros((1, 36)))
    assert set(estimator.get_params()) == {"names", "groups", "predictors", "missing"}
    assert estimator.set_params(predictors=(JAW, LIPS)) is estimator
    alpha, points = visemes()
    np.testing.assert_allclose(estimator.fit_transform(points), alpha, atol=1e-9)
    assert estimator.n_features_in_ == 36
    assert estimator.get_feature_names_out().tolist() == ["jaw", "lips"]
    again = GuidedPCA(**estimator.get_params()).fit(points)
    np.testing.assert_array_equal(again.components_, estimator.components_)
    with pytest.raises(ParameterError, match="no parameter 'modes'"):
        estimator.set_params(modes=3)


def test_a_model_is_saved_and_read_again(tmp_path: Path):
    _, points = visemes(noise=0.1)
    model = replace(fitted(points).model_, source="a test")
    path = tmp_path / "model.npz"
    model.save(path)
    again = load_articulatory(path)
    for name in ("mean", "modes", "variance"):
        np.testing.assert_array_equal(getattr(again, name), getattr(model, name))
    for name in ("names", "predictors", "groups", "source", "parameters"):
        assert getattr(again, name) == getattr(model, name)
    with pytest.raises(OutputError):
        model.save(path)


def test_files_that_are_no_models_are_refused(tmp_path: Path):
    model = fitted(visemes()[1]).model_
    path = tmp_path / "model.npz"
    model.save(path)
    with np.load(path) as archive:
        whole = dict(archive)
    broken = {
        "version": {"version": 9}, "format": {"format": "abs_engine.corpus"},
        "told": {"told": "{"}, "shape": {"mean": whole["mean"][:3]},
        "nan": {"modes": whole["modes"] * np.nan}, "predictors": {"told": '{"predictors": [{}]}'},
    }  # fmt: skip
    for name, change in broken.items():
        np.savez(tmp_path / f"{name}.npz", **{**whole, **change})
        with pytest.raises(ModelFormatError):
            load_articulatory(tmp_path / f"{name}.npz")
    (tmp_path / "text.npz").write_text("no")
    for name in ("text.npz", "none.npz"):
        with pytest.raises(InputFileError):
            load_articulatory(tmp_path / name)


def test_missing_points_are_refused_dropped_or_imputed():
    alpha, points = visemes()
    gappy = points.copy()
    gappy[2, 5], gappy[7, 5], gappy[9, 0, 1] = np.nan, np.nan, np.nan
    with pytest.raises(TooFewPointsError, match="2 points are missing in some visemes: p0, p5"):
        fitted(gappy)
    dropped = fitted(gappy, missing="drop")
    assert dropped.left_out_ == ("p0", "p5")
    assert dropped.imputed_ == {}
    assert dropped.model_.groups["lips"] == ("p4", "p6", "p7")
    np.testing.assert_allclose(dropped.transform(gappy), alpha, atol=1e-9)
    imputed = fitted(gappy, missing="impute")
    assert imputed.imputed_ == {"p0": 1, "p5": 2}
    assert imputed.left_out_ == ()
    np.testing.assert_allclose(imputed.components_, directions(), atol=1e-3)


@pytest.mark.parametrize("missing", ["refuse", "impute"])
def test_a_point_that_is_never_there_is_named(missing: str):
    _, points = visemes()
    points[:, 3] = np.nan
    with pytest.raises(TooFewPointsError, match="p3"):
        fitted(points, missing=missing)


def test_a_predictor_without_points_is_named():
    _, points = visemes()
    points[0, :4] = np.nan
    with pytest.raises(TooFewPointsError, match="predictor 'jaw' has no points"):
        fitted(points, missing="drop")
    with pytest.raises(ParameterError, match="predictor 'x' has no points"):
        Predictor("x", ())
    with pytest.raises(ParameterError, match="asks for 'tongue'"):
        fitted(visemes()[1], Predictor("tongue", ("tongue",)))


@pytest.mark.parametrize(("coordinates", "positive"), [("", "+y"), ("xw", "+x"), ("y", "+z"),
                                                      ("y", "y")])  # fmt: skip
def test_coordinates_that_are_none_are_refused(coordinates: str, positive: str):
    with pytest.raises(ParameterError):
        Predictor("jaw", ("jaw",), coordinates, positive)


@pytest.mark.parametrize(
    "name", ["", " ", "a,b", "a\nb", "a\0", "\ud800", "frame", "rms_mm", "points", "total"]
)
def test_names_that_would_spoil_a_table_are_refused(name: str):
    with pytest.raises(ParameterError) as error:
        Predictor(name, ("jaw",))
    assert len(str(error.value).encode().splitlines()) == 1


def test_a_single_point_may_be_named():
    _, points = visemes()
    found = fitted(points, Predictor("one", ("p1",), "y", "-y"))
    np.testing.assert_allclose(found.components_[0], directions()[0], atol=1e-9)


def test_bad_data_are_refused():
    _, points = visemes()
    with pytest.raises(TooFewPointsError, match="2 visemes for 2 parameters"):
        fitted(points[:2])
    with pytest.raises(ParameterError, match="nothing left to explain"):
        fitted(points, JAW, LIPS, replace(JAW, name="again"))
    with pytest.raises(ParameterError, match="two predictors are named 'jaw'"):
        fitted(points, JAW, LIPS, JAW)
    with pytest.raises(ParameterError, match="shape"):
        fitted(points[:, :11])
    with pytest.raises(ParameterError, match="infinite"):
        fitted(np.where(points > points.max() - 1e-9, np.inf, points))
    with pytest.raises(ParameterError, match="complex"):
        fitted(points + 0j)
    for call in (fitted(points).model_.invert, fitted(points).model_.transform):
        with pytest.raises(ParameterError, match="complex"):
            call(points + 0j)
    with pytest.raises(ParameterError, match="missing is 'guess'"):
        fitted(points, missing="guess")
    with pytest.raises(ParameterError, match="no predictors"):
        GuidedPCA(NAMES, GROUPS, ()).fit(points)
    model = fitted(points).model_
    with pytest.raises(ParameterError):
        model.invert(points[:, :3])
    with pytest.raises(TooFewPointsError, match="do not determine"):
        model.invert(np.where(np.arange(12)[:, None] < 8, np.nan, points[0]) * [1, 1, np.nan])


def test_the_paper_s_predictors():
    assert [p.name for p in PAPER_PREDICTORS] == [
        "jaw1", "lips1", "lips2", "lips3", "lips4", "jaw2", "lar1",
    ]  # fmt: skip
    assert [p.coordinates for p in PAPER_PREDICTORS] == ["y", "xyz", "y", "y", "y", "z", "xyz"]


def test_the_whole_head_follows_by_regression():
    alpha, _ = visemes()
    rng = np.random.default_rng(1)
    neutral = rng.normal(size=(30, 3))
    units, mixing = rng.normal(size=(5, 30, 3)), rng.normal(size=(2, 5))
    offset = np.full(5, 0.3)
    weights = offset + alpha @ mixing
    dense = dense_units(alpha, weights, neutral, units)
    np.testing.assert_allclose(dense.mean, neutral + np.tensordot(offset, units, 1), atol=1e-5)
    np.testing.assert_allclose(dense.modes, np.tensordot(mixing, units, 1), atol=1e-5)
    np.testing.assert_allclose(dense.offset + alpha @ dense.mixing, weights, atol=1e-9)
    assert dense.variance.sum() == pytest.approx(1.0)
    with pytest.raises(ParameterError):
        dense_units(alpha, weights[:, :4], neutral, units)
    with pytest.raises(ParameterError):
        dense_units(alpha[:5], weights[:4], neutral, units)
    with pytest.raises(TooFewPointsError):
        dense_units(alpha[:2], weights[:2], neutral, units)
