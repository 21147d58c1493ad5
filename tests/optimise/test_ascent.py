"""The climbing drivers on functions with known minima."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from abs_engine.core.errors import ParameterError
from abs_engine.core.objective import Evaluation
from abs_engine.core.params import ParamSpec
from abs_engine.optimise import ascent
from abs_engine.optimise.ascent import Forces, Gradient
from abs_engine.optimise.settings import SOLVING

SCALE = np.array([1.0, 0.1, 20.0])
SPEC = ParamSpec(("a", "b", "c"), ("sd", "rad", "mm"), SCALE, -50 * SCALE, 50 * SCALE)
BOTTOM = np.array([2.0, -0.3, 35.0])


class Bowl:
    """A bowl that is round when parameters are measured by their scales, perhaps in steps."""

    def __init__(self, step: float = 0.0) -> None:
        self.step, self.calls, self.directions = step, 0, 0

    def _value(self, x):
        value = float((((x - BOTTOM) / SCALE) ** 2).sum())
        return round(value / self.step) * self.step if self.step else value

    def __call__(self, x):
        self.calls += 1
        return Evaluation(self._value(x), {"bowl": self._value(x)})

    def values(self, vectors):
        self.calls += len(vectors)
        return np.array([self._value(x) for x in vectors])

    def push(self, x):
        """A force that is right in its sense, wrong in its length, and not quite downhill."""
        self.directions += 1
        turned = np.array([[1, 0.3, 0], [-0.3, 1, 0], [0, 0, 0.5]])
        return 0.4 * SCALE * (turned @ ((BOTTOM - x) / SCALE))


@pytest.mark.parametrize("driver", [Forces(1e-6, 100), Gradient(1e-6, 100, 1e-3)])
def test_the_bottom_is_found(driver):
    bowl = Bowl()
    found = driver.minimise(bowl, np.zeros(3), SPEC)
    np.testing.assert_allclose((found.x - BOTTOM) / SCALE, 0, atol=0.02)
    assert found.status == "converged"
    assert found.value == pytest.approx(bowl._value(found.x))
    assert found.terms == {"bowl": found.value}


def test_every_evaluation_is_counted():
    for driver in (Forces(1e-6, 100), Gradient(1e-6, 100)):
        bowl = Bowl()
        found = driver.minimise(bowl, np.zeros(3), SPEC)
        assert found.n_evaluations == bowl.calls + bowl.directions


def test_forces_ask_for_one_direction_an_iteration():
    bowl = Bowl()
    found = Forces(0.0, 5).minimise(bowl, np.zeros(3), SPEC)
    assert bowl.directions == 5
    assert found.status == "evaluation limit"


def test_the_value_never_rises_along_accepted_steps():
    found = Forces(1e-9, 50).minimise(Bowl(), np.array([9.0, 2.0, -300.0]), SPEC)
    assert found.value == found.trace.min() < found.trace[0]


class Valley(Bowl):
    """Fifty times as steep across as along, and the push is its slope: plain steps zigzag."""

    def _value(self, x):
        a, b, c = (x - BOTTOM) / SCALE
        return float((a + b) ** 2 + 50 * (a - b) ** 2 + c**2)

    def push(self, x):
        a, b, c = (x - BOTTOM) / SCALE
        slope = np.array([(a + b) + 50 * (a - b), (a + b) - 50 * (a - b), c])
        return -SCALE * slope / np.linalg.norm(slope)


def test_the_step_before_helps_along_a_valley(monkeypatch):
    starts = 40 * SCALE * np.random.default_rng(3).uniform(-1, 1, (20, 3))

    def ends():
        return [Forces(1e-6, 15).minimise(Valley(), s, SPEC).value for s in starts]

    remembering = np.median(ends())
    monkeypatch.setattr(ascent, "SOLVING", replace(SOLVING, memory=(0.0,)))
    assert remembering < 0.1 * np.median(ends())


class Lopsided(Bowl):
    """Its push is as long as it should be for the shape, and a tenth of that for the pose."""

    def push(self, x):
        return np.array([1.0, 0.1, 0.1]) * (BOTTOM - x)


def test_pose_and_shape_go_by_strides_of_their_own():
    one = ParamSpec(SPEC.names, ("sd", "sd", "sd"), SCALE, SPEC.lower, SPEC.upper)
    starts = 8 * SCALE * np.random.default_rng(4).uniform(-1, 1, (20, 3))
    apart, together = (
        np.array([Forces(0.0, 8).minimise(Lopsided(), x, spec).value for x in starts])
        for spec in (SPEC, one)
    )
    assert np.median(apart / together) < 0.3


class Late(Bowl):
    """Its shape, the first parameter, is not pushed in the first four directions."""

    def __init__(self):
        super().__init__()
        self.looked = []

    def values(self, vectors):
        self.looked.extend(vectors.tolist())
        return super().values(vectors)

    def push(self, x):
        self.directions += 1
        return np.array([self.directions > 4, 0.3, 0.3]) * (BOTTOM - x)


def test_a_part_that_nothing_pushes_keeps_its_stride():
    late = Late()
    found = Forces(0.0, 8).minimise(late, np.zeros(3), SPEC)
    assert found.value < 1e-4
    assert len(late.looked) == len(np.unique(late.looked, axis=0))


@pytest.mark.parametrize("units", [("sd",) * 3, ("mm", "rad", "mm")])
def test_all_parameters_may_be_of_one_kind(units):
    alike = ParamSpec(SPEC.names, units, SCALE, SPEC.lower, SPEC.upper)
    found = Forces(1e-6, 100).minimise(Bowl(), np.zeros(3), alike)
    np.testing.assert_allclose((found.x - BOTTOM) / SCALE, 0, atol=0.02)


def test_a_step_too_short_to_matter_ends_the_walk():
    class Noise(Bowl):
        def _value(self, x):
            return 1.0 + float(np.abs(x).sum() > 0)

    found = Forces(0.0, 50).minimise(Noise(), np.zeros(3), SPEC)
    assert (found.status, found.n_iterations) == ("converged", 1)


@pytest.mark.parametrize("driver", [Forces(0.0, 50), Gradient(0.0, 50)])
def test_nowhere_better_ends_the_walk_at_any_tolerance(driver):
    found = driver.minimise(Bowl(), BOTTOM, SPEC)
    assert (found.status, found.n_iterations) == ("converged", 1)


def test_a_place_without_a_value_does_not_hide_the_others():
    class Hole(Bowl):
        def values(self, vectors):
            values = super().values(vectors)
            values[-1] = np.nan
            return values

    found = Forces(1e-6, 100).minimise(Hole(), np.zeros(3), SPEC)
    np.testing.assert_allclose((found.x - BOTTOM) / SCALE, 0, atol=0.02)


def test_no_walk_ends_without_a_look_along_its_last_direction():
    class Watched(Valley):
        looked = True

        def push(self, x):
            self.looked = False
            return super().push(x)

        def values(self, vectors):
            self.looked = True
            return super().values(vectors)

    for start in 40 * SCALE * np.random.default_rng(3).uniform(-1, 1, (20, 3)):
        valley = Watched()
        Forces(1e-6, 100).minimise(valley, start, SPEC)
        assert valley.looked


def test_no_place_is_looked_at_twice_along_a_direction():
    seen = []

    class Uphill(Bowl):
        def values(self, vectors):
            seen.extend(vectors.round(9).tolist())
            return super().values(vectors)

        def push(self, x):
            return -super().push(x)

    Forces().minimise(Uphill(), np.zeros(3), SPEC)
    assert len(seen) == len(np.unique(seen, axis=0))


def test_steps_of_whole_pixels_do_not_stop_the_gradient():
    rough = Bowl(step=0.05)
    fine, coarse = (Gradient(0.0, 60, r).minimise(rough, np.zeros(3), SPEC) for r in (1e-3, 0.5))
    assert coarse.value <= 0.05 < fine.value


def test_at_the_bottom_they_stay():
    for driver in (Forces(), Gradient()):
        found = driver.minimise(Bowl(), BOTTOM, SPEC)
        np.testing.assert_array_equal(found.x, BOTTOM)
        assert found.status == "converged"


def test_bounds_hold():
    near = ParamSpec(SPEC.names, SPEC.units, SCALE, -SCALE, SCALE)
    for driver in (Forces(1e-6, 50), Gradient(1e-6, 50)):
        found = driver.minimise(Bowl(), np.zeros(3), near)
        assert (np.abs(found.x) <= SCALE).all()
        assert found.x[0] == pytest.approx(1.0, abs=0.05)


def test_slopes_at_a_bound_are_measured_within_it():
    seen = []

    class Slope(Bowl):
        def _value(self, x):
            return float((x / SCALE).sum())

        def values(self, vectors):
            seen.extend(vectors)
            return super().values(vectors)

    start = np.array([0.0, 50.0, 0.0]) * SCALE
    Gradient(0.0, 1, 0.5).minimise(Slope(), start, SPEC)
    assert np.all(np.array(seen) <= SPEC.upper)
    moved = (seen[6:] - start) / SCALE  # after three differences
    np.testing.assert_allclose(moved[:, 1], moved[:, 2], atol=1e-9)
    assert np.abs(moved[:, 1]).max() > 0.1


def test_a_push_that_is_far_too_long_is_shortened():
    class Wild(Bowl):
        def push(self, x):
            return 1e9 * super().push(x)

    found = Forces(1e-6, 100).minimise(Wild(), np.zeros(3), SPEC)
    assert found.value < 0.5


@pytest.mark.parametrize("start", [np.zeros(2), np.array([0, np.nan, 0])])
def test_a_bad_start_is_refused(start):
    with pytest.raises(ParameterError, match="start"):
        Forces().minimise(Bowl(), start, SPEC)
