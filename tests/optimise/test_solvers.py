"""The solvers beside the simplex: what they find, that they keep bounds and limits."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.core.errors import ParameterError
from abs_engine.core.objective import Evaluation
from abs_engine.core.params import ParamSpec
from abs_engine.optimise.anchored import Held
from abs_engine.optimise.axes import AxesSimplex
from abs_engine.optimise.by_nlopt import METHODS, DerivativeFree, Simplex
from abs_engine.optimise.levenberg import LevenbergMarquardt
from abs_engine.optimise.newton import Newton
from abs_engine.optimise.restarted import RestartedSimplex
from abs_engine.optimise.variations import LocalVariations

MIDDLE = np.array([1.0, -0.5, 0.3])


class Bowl:
    """A tilted quadratic bowl, as a value and as residuals; slopes by differences."""

    unit = 1.0

    def __init__(self, middle=MIDDLE) -> None:
        rng = np.random.default_rng(3)
        self.matrix = np.eye(6, 3) + 0.15 * rng.normal(size=(6, 3))
        self.middle, self.seen = np.asarray(middle), []

    def residuals(self, x):
        self.seen.append(np.array(x))
        return self.matrix @ (x - self.middle)

    def __call__(self, x) -> Evaluation:
        away = self.residuals(x)
        return Evaluation(float(away @ away), {"bowl": float(away @ away)})

    def values(self, vectors):
        return np.array([self(x).value for x in vectors])

    def gauss_newton(self, x, scale, difference):
        here, *beside = (self.residuals(y) for y in [x, *(x + np.diag(difference * scale))])
        slopes = (np.array(beside) - here) / difference
        return float(here @ here), slopes @ slopes.T, slopes @ here


def spec(reach: float = 5.0) -> ParamSpec:
    ones = np.ones(3)
    return ParamSpec(("a", "b", "c"), ("sd",) * 3, 0.5 * ones, -reach * ones, reach * ones)


SOLVERS = {
    **{m: lambda t, n, m=m: DerivativeFree(m, t, n) for m in METHODS},
    "levenberg": LevenbergMarquardt,
    "axes": lambda t, n: AxesSimplex(n, t, t),
    "variations": LocalVariations,
    "restarted": RestartedSimplex,
}
BY_MATRIX = ("levenberg", "axes")
"""Those whose every matrix costs several evaluations and has one value."""


@pytest.mark.parametrize("name", SOLVERS)
def test_a_bowl_is_found(name):
    bowl = Bowl()
    found = SOLVERS[name](1e-10, 3000).minimise(bowl, np.zeros(3), spec())
    np.testing.assert_allclose(found.x, MIDDLE, atol=0.02)
    assert found.n_evaluations == len(bowl.seen)
    assert len(found.trace) <= len(bowl.seen)
    assert (len(found.trace) == len(bowl.seen)) == (name not in BY_MATRIX)
    assert found.value == found.trace.min()


@pytest.mark.parametrize("name", SOLVERS)
def test_bounds_are_kept(name):
    bowl = Bowl([3.0, 0.0, -3.0])
    SOLVERS[name](1e-8, 300).minimise(bowl, np.array([9.0, 0.0, 0.0]), spec(2.0))
    assert np.abs(bowl.seen).max() <= 2 + 1e-12


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("limit", [1, 7, 20])
def test_the_limit_is_kept(name, limit):
    bowl = Bowl()
    found = SOLVERS[name](1e-15, limit).minimise(bowl, np.zeros(3), spec())
    assert len(bowl.seen) == found.n_evaluations <= limit
    if name not in BY_MATRIX:  # they stop where there is no room for another matrix
        assert found.n_evaluations == limit
        assert found.status == "evaluation limit"
    assert found.value <= Bowl()(np.zeros(3)).value


@pytest.mark.parametrize("name", SOLVERS)
@pytest.mark.parametrize("start", [[np.nan, 0, 0], [0, 0]])
def test_a_start_that_cannot_be(name, start):
    with pytest.raises(ParameterError, match="give 3 numbers"):
        SOLVERS[name](1e-3, 50).minimise(Bowl(), np.array(start, float), spec())


def test_a_restart_is_never_worse():
    def valley(x) -> Evaluation:
        return Evaluation(float(200 * (x[1] - x[0] ** 2) ** 2 + (1 - x[0]) ** 2 + x[2] ** 2))

    start = np.array([-1.5, 1.0, 0.4])
    once = Simplex(1e-3, 2000).minimise(valley, start, spec())
    again = RestartedSimplex(1e-3, 2000, 3).minimise(valley, start, spec())
    assert again.value <= once.value
    np.testing.assert_array_equal(again.trace[: once.n_evaluations], once.trace)


@pytest.mark.parametrize(("more", "status"), [(1000, "converged"), (3, "evaluation limit")])
def test_a_restart_that_is_cut_short_says_so(more, status):
    """Also where it had found nothing better yet."""
    once = Simplex(1e-9, 1000).minimise(Bowl(), np.zeros(3), spec())
    solver = RestartedSimplex(1e-9, once.n_evaluations + more, 1)
    assert solver.minimise(Bowl(), np.zeros(3), spec()).status == status


class Curved(Bowl):
    """The bowl with its exact slope and curvature."""

    def newton(self, x, _reach, _local=False):
        curve = 2 * self.matrix.T @ self.matrix
        return self(x).value, curve @ (x - self.middle), curve


@pytest.mark.parametrize(("gain", "moves"), [(0.8, True), (1.2, False)])
def test_a_newton_step_is_tried_where_it_promises_its_gain(gain, moves):
    """The promise, of a bowl, is the whole of its value."""
    bowl, start = Curved(), np.zeros(3)
    solver = Newton(gain=gain * bowl(start).value, more=0.0)
    found = solver.descend(bowl, start, spec(), 20)
    np.testing.assert_allclose(found.x, MIDDLE if moves else start, atol=1e-6)


def test_a_pull_to_the_start_is_no_part_of_the_value():
    """By it ends of searches with and without are compared."""
    bowl, solver = Bowl(), AxesSimplex(300, 1e-10, 1e-10, inertia=0.5)
    start, inside = np.zeros(3), spec()
    once = solver.descend(bowl, start, inside, 100)
    best = solver.minimise(bowl, start, inside)
    for found in (once, best):
        assert found.value == pytest.approx(bowl(found.x).value, rel=1e-9)
        assert np.linalg.norm(found.x) < 0.9 * np.linalg.norm(MIDDLE)
    assert best.n_evaluations <= 300


@pytest.mark.parametrize("x", [[0.2, 0.4, -0.3], [5.0, 5.0, 5.0]])  # within, and at the bounds
def test_a_held_objective_s_slope_and_curvature_are_those_of_its_values(x):
    held, scale, small = Held(Bowl(), spec(), np.full(3, 0.1), inertia=0.7), spec().scale, 1e-4
    value, matrix, gradient = held.gauss_newton(np.array(x), 0.1)
    assert value == pytest.approx(held.values(np.array([x]))[0])
    steps = small * np.diag(scale)
    ahead, back = held.values(x + steps), held.values(x - steps)
    np.testing.assert_allclose(2 * gradient, (ahead - back) / (2 * small), rtol=1e-5)
    bent = (ahead + back - 2 * value) / small**2
    np.testing.assert_allclose(2 * np.diag(matrix), bent, rtol=1e-3)


def test_a_polish_is_pulled_to_the_centre_it_is_given():
    bowl, solver = Bowl(), AxesSimplex(300, 1e-10, 1e-10, inertia=0.5)
    start, inside = np.zeros(3), spec()
    free = solver.descend(bowl, start, inside, 100, free=True)
    np.testing.assert_allclose(free.x, MIDDLE, atol=1e-3)
    best = solver.polish(bowl, free, inside, start, 300)
    pulled = solver.minimise(bowl, start, inside)
    np.testing.assert_allclose(best.x, pulled.x, atol=0.02)
    assert best.value == pytest.approx(bowl(best.x).value, rel=1e-9)


def test_what_cannot_be_asked_for():
    with pytest.raises(ParameterError, match="choose one of sbplx"):
        DerivativeFree("gradient")
    with pytest.raises(ParameterError, match="no residuals"):
        LevenbergMarquardt().minimise(lambda x: Evaluation(0.0), np.zeros(3), spec())
    with pytest.raises(ParameterError, match="no residuals"):
        AxesSimplex().minimise(lambda x: Evaluation(0.0), np.zeros(3), spec())
