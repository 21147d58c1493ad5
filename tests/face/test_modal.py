"""Learned physics: modes that were put in come out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from abs_engine.core.errors import InputFileError, ModelFormatError, OutputError, ParameterError
from abs_engine.face.shape.modal import learn, load_physics
from abs_engine.face.shape.posterior import expected_posterior, reconstruct

N, TRUE = 12, np.array([9.0, 4.0, 1.0])
RNG = np.random.default_rng(3)
BASIS = np.linalg.qr(RNG.normal(size=(3 * N, 3)))[0].T.reshape(3, N, 3)
REST, MEAN = RNG.normal(size=(N, 3)), 0.3 * RNG.normal(size=(N, 3))


def motion(frames: int, noise: float = 0.0, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    moved = np.tensordot(rng.normal(size=(frames, 3)) * np.sqrt(TRUE), BASIS, 1)
    return MEAN + moved + noise * rng.normal(size=(frames, N, 3))


PHYSICS = learn(REST, motion(4000), 3)


def test_modes_and_variances_are_those_that_were_put_in():
    np.testing.assert_allclose(PHYSICS.variances, TRUE, rtol=0.08)
    overlap = np.abs(PHYSICS.matrix.T @ BASIS.reshape(3, -1).T)
    np.testing.assert_allclose(overlap, np.eye(3), atol=0.05)
    np.testing.assert_allclose(PHYSICS.mean, MEAN, atol=0.1)
    assert PHYSICS.held == pytest.approx(1.0)
    np.testing.assert_allclose(PHYSICS.shares, np.cumsum(TRUE) / TRUE.sum(), atol=0.02)


def test_variances_of_unequal_weights_are_unbiased():
    weights = np.r_[np.full(20, 1 / 20), np.full(2, 1 / 2)]
    drawn = [learn(REST, motion(22, seed=k), 3, weights=weights).total for k in range(500)]
    assert np.mean(drawn) == pytest.approx(TRUE.sum(), rel=0.05)
    equal = learn(REST, motion(22), 3, weights=np.full(22, 0.3))
    np.testing.assert_allclose(equal.variances, learn(REST, motion(22), 3).variances)
    rows = motion(22).reshape(22, -1)
    assert equal.total == pytest.approx(rows.var(axis=0, ddof=1).sum())


def test_held_is_the_share_of_the_variance():
    noisy = learn(REST, motion(4000, noise=0.5), 3)
    assert noisy.held == pytest.approx(14.75 / (14 + 36 * 0.25), abs=0.02)


def test_coefficients_of_a_shape_come_back():
    given = RNG.normal(size=(5, 3))
    np.testing.assert_allclose(PHYSICS.coefficients(PHYSICS.shape(given)), given, atol=1e-12)


class TestReconstruct:
    TRUTH = np.array([[2.0, -1.0, 0.5], [-4.0, 3.0, -1.0]])
    DOFS = np.array([0, 1, 2, 9, 10, 11, 20, 30])

    def observed(self):
        return PHYSICS.shape(self.TRUTH).reshape(2, -1)[:, self.DOFS]

    def conditioned(self, noise):
        """Mean and covariance of the shape by the conditional Gaussian of all coordinates."""
        s = PHYSICS.matrix
        covariance = s @ np.diag(PHYSICS.variances) @ s.T
        among = covariance[np.ix_(self.DOFS, self.DOFS)] + noise**2 * np.eye(len(self.DOFS))
        gain = np.linalg.solve(among, covariance[self.DOFS]).T
        centre = (PHYSICS.rest + PHYSICS.mean).ravel()
        mean = centre + (self.observed() - centre[self.DOFS]) @ gain.T
        return mean, covariance - gain @ covariance[self.DOFS]

    def test_a_few_exact_coordinates_give_the_whole(self):
        found = reconstruct(PHYSICS, self.DOFS, self.observed(), 1e-6)
        np.testing.assert_allclose(found.coefficients, self.TRUTH, atol=1e-6)
        assert found.deviation < 1e-5

    def test_noise_pulls_to_the_mean(self):
        found = reconstruct(PHYSICS, self.DOFS, self.observed(), 1e3)
        np.testing.assert_allclose(found.coefficients, 0, atol=1e-3)
        np.testing.assert_allclose(found.covariance, np.diag(PHYSICS.variances), atol=1e-3)

    def test_it_is_the_conditional_gaussian(self):
        mean, covariance = self.conditioned(0.7)
        found = reconstruct(PHYSICS, self.DOFS, self.observed(), 0.7)
        np.testing.assert_allclose(found.shapes.reshape(2, -1), mean, atol=1e-9)
        modes = PHYSICS.matrix
        np.testing.assert_allclose(modes @ found.covariance @ modes.T, covariance, atol=1e-9)
        assert found.deviation == pytest.approx(np.sqrt(np.trace(covariance) / N))

    def test_weighted_rows_see_what_degrees_of_freedom_do(self):
        rows = sparse.csr_matrix(np.eye(3 * N)[self.DOFS])
        plain = reconstruct(PHYSICS, self.DOFS, self.observed(), 0.7)
        weighted = reconstruct(PHYSICS, rows, self.observed(), 0.7)
        np.testing.assert_allclose(weighted.coefficients, plain.coefficients, atol=1e-12)
        np.testing.assert_allclose(weighted.covariance, plain.covariance, atol=1e-12)

    def test_it_is_as_far_off_as_it_says(self):
        rng = np.random.default_rng(8)
        truth = rng.normal(size=(3000, 3)) * np.sqrt(PHYSICS.variances)
        shapes = PHYSICS.shape(truth)
        noisy = shapes.reshape(3000, -1)[:, self.DOFS] + 0.5 * rng.normal(size=(3000, 8))
        found = reconstruct(PHYSICS, self.DOFS, noisy, 0.5)
        away = np.sqrt(((found.shapes - shapes) ** 2).sum(axis=2).mean(axis=0))
        modes = PHYSICS.modes
        nodes = np.einsum("pnd,pq,qnd->n", modes, found.covariance, modes)
        np.testing.assert_allclose(away, np.sqrt(nodes), rtol=0.06)
        np.testing.assert_allclose(
            expected_posterior(PHYSICS, self.DOFS, 0.5).covariance, found.covariance
        )

    @pytest.mark.parametrize(("dofs", "noise"), [([], 1.0), ([0], 0.0)])
    def test_nothing_to_go_by_is_refused(self, dofs, noise):
        with pytest.raises(ParameterError, match="nothing is observed"):
            reconstruct(PHYSICS, np.array(dofs, int), np.zeros(len(dofs)), noise)

    def test_values_that_do_not_fit_are_refused(self):
        with pytest.raises(ParameterError, match="3 values for 8"):
            reconstruct(PHYSICS, self.DOFS, np.zeros(3), 1.0)

    def test_what_is_not_finite_or_not_of_the_shell_is_refused(self):
        with pytest.raises(ParameterError, match="not finite"):
            reconstruct(PHYSICS, self.DOFS, np.full(8, np.nan), 1.0)
        for wrong in (-1, 3 * N):
            with pytest.raises(ParameterError, match=f"no degree of freedom {wrong}"):
                reconstruct(PHYSICS, np.array([0, wrong]), np.zeros(2), 1.0)
        with pytest.raises(ParameterError, match="do not fit"):
            reconstruct(PHYSICS, sparse.eye(5).tocsr(), np.zeros(5), 1.0)


def test_it_comes_back_from_a_file(tmp_path):
    told = replace(PHYSICS, noise=0.1, person="mei", speaker="0f", source="a session")
    told.save(tmp_path / "lips.npz")
    back = load_physics(tmp_path / "lips.npz")
    for name, value in vars(told).items():
        np.testing.assert_array_equal(getattr(back, name), value)
    with pytest.raises(OutputError, match="exists"):
        told.save(tmp_path / "lips.npz")


def test_files_that_are_none_are_named(tmp_path):
    with pytest.raises(InputFileError):
        load_physics(tmp_path / "none.npz")
    kind = {"format": "abs_engine.learned_physics", "version": 2}
    np.savez(tmp_path / "half.npz", **kind, rest=REST)
    with pytest.raises(ModelFormatError, match="lacks"):
        load_physics(tmp_path / "half.npz")
    np.savez(tmp_path / "odd.npz", **kind, **{**vars(PHYSICS), "mean": np.zeros(3)})
    with pytest.raises(ModelFormatError, match="has shape"):
        load_physics(tmp_path / "odd.npz")


def test_too_little_motion_is_refused():
    with pytest.raises(ParameterError, match="4 modes asked for, 40 frames span 3"):
        learn(REST, motion(40), 4)
    with pytest.raises(ParameterError, match="span 0"):
        learn(REST, np.zeros((5, N, 3)), 1)
    with pytest.raises(ParameterError, match="span 0"):
        learn(REST, np.repeat(motion(1), 30, axis=0), 1)
    with pytest.raises(ParameterError, match="not frames"):
        learn(REST, np.zeros((0, N, 3)), 1)


def test_what_is_not_finite_is_named():
    data = motion(20)
    data[7, 3, 1] = np.nan
    with pytest.raises(ParameterError, match="frame 7"):
        learn(REST, data, 2)
