"""The simplex: what it finds, when it stops, what it refuses."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.core.errors import ParameterError
from abs_engine.core.objective import Evaluation
from abs_engine.core.params import ParamSpec
from abs_engine.optimise.by_nlopt import Simplex


def spec(n: int = 2, reach: float = 5.0, scale: float = 0.5) -> ParamSpec:
    names = tuple(f"p{k}" for k in range(n))
    return ParamSpec(names, ("sd",) * n, np.full(n, scale), np.full(n, -reach), np.full(n, reach))


def rosenbrock(x) -> Evaluation:
    steep, flat = 100 * (x[1] - x[0] ** 2) ** 2, (1 - x[0]) ** 2
    return Evaluation(float(steep + flat), {"steep": float(steep), "flat": float(flat)})


def bowl(x) -> Evaluation:
    return Evaluation(float(((x - 3.0) ** 2).sum()))


def test_rosenbrock():
    solution = Simplex(tolerance=1e-12, limit=2000).minimise(
        rosenbrock, np.array([-1.2, 1.0]), spec()
    )
    np.testing.assert_allclose(solution.x, [1, 1], atol=1e-4)
    assert solution.status == "converged"
    assert solution.n_evaluations == len(solution.trace) < 2000
    assert solution.value == solution.trace.min() == rosenbrock(solution.x).value
    assert solution.terms == rosenbrock(solution.x).terms


def test_bounds_are_kept():
    seen = []

    def watched(x) -> Evaluation:
        seen.append(x.copy())
        return bowl(x)

    solution = Simplex(1e-10, 1000).minimise(watched, np.array([-9.0, 0.0]), spec(reach=2.0))
    assert np.abs(seen).max() <= 2
    np.testing.assert_array_equal(seen[0], [-2, 0])
    np.testing.assert_allclose(solution.x, [2, 2], atol=1e-4)


def test_the_first_steps_are_the_parameters_scales():
    scale = np.array([0.1, 2.0])
    whole = ParamSpec(("a", "b"), ("mm", "sd"), scale, np.full(2, -50.0), np.full(2, 50.0))
    seen = []

    def watched(x) -> Evaluation:
        seen.append(x.copy())
        return Evaluation(float(x @ x))

    Simplex().minimise(watched, np.zeros(2), whole, step=0.5)
    np.testing.assert_allclose(np.abs(seen[1:3]), np.diag(0.5 * scale))


def test_the_limit_ends_it():
    solution = Simplex(tolerance=1e-15, limit=17).minimise(rosenbrock, np.zeros(2), spec())
    assert solution.status == "evaluation limit"
    assert solution.n_evaluations == 17


@pytest.mark.parametrize("limit", [1, 2, 3, 10, 60])
def test_never_worse_than_the_start(limit):
    rng = np.random.default_rng(limit)
    for _ in range(20):
        start, middle, noise = rng.normal(0, 2, 4), rng.normal(0, 2, 4), rng.normal(0, 9, 4)

        def rough(x, middle=middle, noise=noise) -> Evaluation:
            return Evaluation(float(((x - middle) ** 2).sum() + 3 * np.sin(x @ noise)))

        solution = Simplex(1e-6, limit).minimise(rough, start, spec(4))
        assert solution.value <= rough(start).value
        assert solution.value == rough(solution.x).value


def test_a_flat_objective_converges():
    solution = Simplex().minimise(lambda _: Evaluation(4.0), np.zeros(3), spec(3))
    assert solution.status == "converged"
    assert solution.value == 4


@pytest.mark.parametrize("start", [[np.nan, 0], [np.inf, 0], [0, 0, 0], [0]])
def test_a_start_that_cannot_be(start):
    with pytest.raises(ParameterError, match="give 2 numbers"):
        Simplex().minimise(bowl, np.array(start, float), spec())


def test_an_objective_that_breaks_is_heard():
    def broken(_) -> Evaluation:
        raise ValueError("no picture")

    with pytest.raises(ValueError, match="no picture"):
        Simplex().minimise(broken, np.zeros(2), spec())
