"""Learned physics: modes that were put in come out."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.errors import InputFileError, ModelFormatError, ParameterError
from abs_engine.shape.modal import learn, load_physics, reconstruct

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


def test_held_is_the_share_of_the_variance():
    noisy = learn(REST, motion(4000, noise=0.5), 3)
    assert noisy.held == pytest.approx(14.75 / (14 + 36 * 0.25), abs=0.02)


def test_coefficients_of_a_shape_come_back():
    given = RNG.normal(size=(5, 3))
    np.testing.assert_allclose(PHYSICS.coefficients(PHYSICS.shape(given)), given, atol=1e-12)


def test_the_inverse_stiffness_is_the_root_of_the_covariance():
    """Eq. 3 backwards: K^-1 K^-1 = R_u, and pushing is multiplying with it."""
    data = motion(4000).reshape(4000, -1)
    values, vectors = np.linalg.eigh(np.cov(data.T))
    root = vectors @ np.diag(np.sqrt(np.clip(values, 0, None))) @ vectors.T
    forces = RNG.normal(size=(N, 3))
    moved = np.tensordot(PHYSICS.pushed(forces), PHYSICS.modes, 1)
    np.testing.assert_allclose(moved.ravel(), root @ forces.ravel(), atol=1e-5)


def test_the_prior_is_half_the_sum_of_eq_10():
    value = PHYSICS.negative_log_prior(np.array([3.0, 2.0, 1.0]) * np.sqrt(PHYSICS.variances))
    assert value == pytest.approx(0.5 * (9 + 4 + 1))


class TestReconstruct:
    TRUTH = np.array([[2.0, -1.0, 0.5], [-4.0, 3.0, -1.0]])
    DOFS = np.array([0, 1, 2, 9, 10, 11, 20, 30])

    def observed(self):
        return PHYSICS.shape(self.TRUTH).reshape(2, -1)[:, self.DOFS]

    def test_a_few_exact_coordinates_give_the_whole(self):
        found = reconstruct(PHYSICS, self.DOFS, self.observed(), 1e-6)
        np.testing.assert_allclose(found, self.TRUTH, atol=1e-6)

    def test_noise_pulls_to_the_mean(self):
        found = reconstruct(PHYSICS, self.DOFS, self.observed(), 1e3)
        np.testing.assert_allclose(found, 0, atol=1e-3)

    def test_it_is_the_mean_of_the_conditional_gaussian(self):
        s, noise = PHYSICS.matrix, 0.7
        covariance = s @ np.diag(PHYSICS.variances) @ s.T
        among = covariance[np.ix_(self.DOFS, self.DOFS)] + noise**2 * np.eye(len(self.DOFS))
        centre = (PHYSICS.rest + PHYSICS.mean).ravel()
        away = (self.observed() - centre[self.DOFS]).T
        expected = centre[:, None] + covariance[:, self.DOFS] @ np.linalg.solve(among, away)
        found = PHYSICS.shape(reconstruct(PHYSICS, self.DOFS, self.observed(), noise))
        np.testing.assert_allclose(found.reshape(2, -1), expected.T, atol=1e-9)

    @pytest.mark.parametrize(("dofs", "noise"), [([], 1.0), ([0], 0.0)])
    def test_nothing_to_go_by_is_refused(self, dofs, noise):
        with pytest.raises(ParameterError, match="nothing observed"):
            reconstruct(PHYSICS, np.array(dofs, int), np.zeros(len(dofs)), noise)


def test_it_comes_back_from_a_file(tmp_path):
    PHYSICS.save(tmp_path / "lips.npz")
    back = load_physics(tmp_path / "lips.npz")
    for name, value in vars(PHYSICS).items():
        np.testing.assert_array_equal(getattr(back, name), value)


def test_files_that_are_none_are_named(tmp_path):
    with pytest.raises(InputFileError):
        load_physics(tmp_path / "none.npz")
    np.savez(tmp_path / "half.npz", format="abs_engine.learned_physics", version=1, rest=REST)
    with pytest.raises(ModelFormatError, match="lacks"):
        load_physics(tmp_path / "half.npz")


def test_too_little_motion_is_refused():
    with pytest.raises(ParameterError, match="4 modes asked for, 40 frames span 3"):
        learn(REST, motion(40), 4)
    with pytest.raises(ParameterError, match="span 0"):
        learn(REST, np.zeros((5, N, 3)), 1)


def test_what_is_not_finite_is_named():
    data = motion(20)
    data[7, 3, 1] = np.nan
    with pytest.raises(ParameterError, match="frame 7"):
        learn(REST, data, 2)
