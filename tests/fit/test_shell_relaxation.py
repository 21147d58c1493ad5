"""The full-rank shell settles on what one camera or several saw at once."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from lip_clips import FRONT, HEADS, LEFT, RIGHT, lips, seen

from abs_engine.core.scene import Candidates
from abs_engine.face.shape.fem import ThinShell
from abs_engine.face.shape.lip_model import LipModel
from abs_engine.face.shape.lip_shell import COLUMNS
from abs_engine.fit.shell_relaxation import Settled, relaxed, settle, shared_shape, softness

ROUNDED = (5, 12, 20, 26)
LIPS = slice(0, 3 * COLUMNS)


@cache
def elastic() -> ThinShell:
    return lips().model.shell.elastic_at(lips().model.physics.rest)


@cache
def model(typical: float = 0.8, count: int = 40) -> LipModel:
    """Lips that may leave their modes, by so many mm."""
    free = relaxed(lips().model.physics, elastic(), softness(elastic(), typical), count)
    return replace(lips().model, physics=free)


@cache
def settled(frame: int, *poses: object) -> Settled:
    own = model()
    return settle(own, [seen(frame, pose) for pose in poses], np.zeros((1, own.n_modes)))


def away(frame: int, found: Settled) -> np.ndarray:
    """Of the lips' nodes from the truth, (102, 3) mm."""
    physics = lips().model.physics
    return (physics.rest + found.moved - lips().model.shell.nodes(HEADS[frame]))[LIPS]


def test_nodes_move_as_far_as_the_temperature_says():
    """Displacements drawn from N(0, T K^-1) by the stiffness's own Cholesky factor."""
    shell, typical = elastic(), 0.4
    temperature = softness(shell, typical)
    assert softness(shell, 3 * typical) == pytest.approx(9 * temperature)
    factor = np.linalg.cholesky(shell.stiffness.toarray() / temperature)
    rng = np.random.default_rng(0)
    drawn = np.linalg.solve(factor.T, rng.normal(size=(612, 2000))).T.reshape(-1, 204, 3)
    assert np.sqrt((drawn**2).sum(axis=2).mean()) == pytest.approx(typical, rel=0.02)
    strained = drawn[:200].reshape(200, -1)
    energy = 0.5 * ((strained @ shell.stiffness.toarray()) * strained).sum(axis=1).mean()
    assert energy / temperature == pytest.approx(612 / 2, rel=0.03)  # equipartition


def test_a_relaxed_shell_has_the_modes_covariance_and_the_elastic_one():
    physics, temperature = lips().model.physics, softness(elastic(), 0.5)
    free = relaxed(physics, elastic(), temperature, 612)
    found = (free.matrix * free.variances) @ free.matrix.T
    modal = (physics.matrix * physics.deviations**2) @ physics.matrix.T
    wanted = modal + temperature * np.linalg.inv(elastic().stiffness.toarray())
    np.testing.assert_allclose(found, wanted, atol=1e-8)
    np.testing.assert_array_equal(free.rest, physics.rest)
    np.testing.assert_array_equal(free.mean, physics.mean)
    few = relaxed(physics, elastic(), temperature, 20)
    np.testing.assert_allclose(few.deviations, free.deviations[:20])
    assert few.held > 0.9


def test_several_views_add_up_and_the_prior_counts_once():
    own, x = model(), np.linspace(-1, 1, 40)
    views = [seen(12, pose) for pose in (FRONT, LEFT)]
    each = [
        replace(v.colours, scene=own.scene()).negative_log(Candidates.one(x, v.pose))[0]
        for v in views
    ]
    problem = shared_shape(own, views)
    assert problem(x).value == pytest.approx(sum(each) + 0.5 * x @ x, rel=1e-6)
    alone = [shared_shape(own, [v]).newton(x, 4) for v in views]
    value, slope, curve = problem.newton(x, 4)
    assert value == pytest.approx(problem(x).value, rel=1e-6)
    np.testing.assert_allclose(slope, alone[0][1] + alone[1][1] - x, atol=1e-8)
    np.testing.assert_allclose(curve, alone[0][2] + alone[1][2] - np.eye(40), atol=1e-8)


def test_the_posterior_is_never_worse_than_any_start():
    own = model()
    starts = np.random.default_rng(0).normal(size=(6, own.n_modes))
    views = [seen(20, pose) for pose in (FRONT, LEFT)]
    found = settle(own, views, starts)
    problem = shared_shape(own, views)
    assert found.value <= problem.values(starts).min()
    assert found.value == pytest.approx(problem(found.weights).value, rel=1e-6)


def test_a_second_view_shows_the_depth_that_one_hides():
    """Lips that never saw rounding, on rounded ones: their depth is not in what was learned."""
    one = [away(k, settled(k, FRONT)) for k in ROUNDED]
    more = [away(k, settled(k, FRONT, LEFT, RIGHT)) for k in ROUNDED]
    depth = [np.sqrt(np.mean(np.square([a[:, 2] for a in of]))) for of in (one, more)]
    assert depth[1] < 0.8 * depth[0]
    plane = np.sqrt(np.mean(np.square([a[:, :2] for a in more])))
    assert plane < 0.8


def test_nodes_leave_the_modes_towards_the_truth():
    """More freedom than the ten modes have brings the lips nearer in the pictures' planes."""
    physics = lips().model.physics
    stiff = [
        settle(lips().model, [seen(k, p) for p in (FRONT, LEFT, RIGHT)], np.zeros((1, 10)))
        for k in ROUNDED
    ]
    loose = [settled(k, FRONT, LEFT, RIGHT) for k in ROUNDED]
    outside = [
        s.moved - physics.shape(physics.coefficients(physics.rest + s.moved)) + physics.rest
        for s in (stiff[1], loose[1])
    ]
    assert np.abs(outside[0]).max() < 1e-6 < 0.05 < np.abs(outside[1]).max()
    error = [
        np.mean([(away(k, s) ** 2).mean() for k, s in zip(ROUNDED, of, strict=True)])
        for of in (stiff, loose)
    ]
    assert error[1] < error[0]


def test_what_no_view_shows_keeps_the_priors_variance():
    one, more = settled(12, FRONT), settled(12, FRONT, LEFT, RIGHT)
    for found in (one, more):
        size = np.linalg.eigvalsh(found.covariance)
        assert 0 < size.min() < 0.2
        assert size.max() <= 1 + 1e-9
    assert np.trace(more.covariance) < np.trace(one.covariance)


def test_the_evidence_is_the_posterior_integrated_over_the_weights():
    """By Laplace, exactly for a Gaussian: -log of N(data; 0, 1 + noise) in one dimension."""
    data, noise = 1.7, 0.3
    precision = 1 + 1 / noise**2
    mean = data / noise**2 / precision
    value = 0.5 * ((data - mean) / noise) ** 2 + np.log(noise) + 0.5 * mean**2
    found = Settled(np.zeros((1, 3)), np.array([mean]), np.array([[1 / precision]]), value)
    wanted = 0.5 * data**2 / (1 + noise**2) + 0.5 * np.log(1 + noise**2)
    assert found.evidence == pytest.approx(wanted)
