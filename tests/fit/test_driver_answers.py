"""A plugin's driver that answers wrongly is named; the engine's own are not looked at."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from abs_engine.core.errors import PluginError
from abs_engine.core.objective import Evaluation
from abs_engine.core.params import ParamSpec
from abs_engine.fit.answers import check_value
from abs_engine.fit.search import search, several
from abs_engine.optimise.base import Solution
from abs_engine.optimise.drivers import SIMPLEX, Driver

SPEC = ParamSpec(("a", "b"), ("", ""), np.ones(2), np.full(2, -9.0), np.full(2, 9.0))
START = np.array([1.0, 2.0])
RIGHT = Solution(START, "stayed", 5.0, {}, 1)


@dataclass
class Bowl:
    """A sum of squares."""

    spec: ParamSpec = field(default_factory=lambda: SPEC)

    def __call__(self, x):
        return Evaluation(float(x @ x))

    def values(self, vectors):
        return (vectors**2).sum(axis=1)


class Kept:
    """Returns what it was made with."""

    def __init__(self, given) -> None:
        self.given = given

    def minimise(self, objective, start, spec):
        if isinstance(self.given, BaseException):
            raise self.given
        return self.given


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ((START, 5.0), "the driver 'Kept' returns an object of type tuple; return a Solution"),
        (None, "returns an object of type NoneType"),
        (replace(RIGHT, x=START[:1]), "returns an x that is not 2 finite numbers"),
        (replace(RIGHT, x=START * np.nan), "returns an x that is not 2 finite numbers"),
        (replace(RIGHT, x=[[1.0], [1.0, 2.0]]), "returns an x that is not 2 finite numbers"),
        (replace(RIGHT, status=None), "returns the status None"),
        (replace(RIGHT, value=None), "a value or a count of evaluations that is not a finite"),
        (replace(RIGHT, value=np.inf), "a value or a count of evaluations that is not a finite"),
        (KeyError("step"), "fails (KeyError: 'step') in test_driver_answers.py, line "),
        (SystemExit(3), "fails (SystemExit: 3) in test_driver_answers.py, line "),
    ],
)
def test_a_driver_that_answers_wrongly_is_named(given, said):
    for searched in (
        lambda: search(Bowl(), START[None], Kept(given)),
        lambda: several(Bowl(), START[None], Kept(given), 1),
    ):
        with pytest.raises(PluginError) as caught:
            searched()
        assert said in str(caught.value)
        if isinstance(given, BaseException):
            assert caught.value.__cause__ is given


def test_lists_and_numbers_of_numpy_are_taken():
    found = search(Bowl(), START[None], Kept(replace(RIGHT, x=[1, 2], value=np.array(5.0))))
    assert isinstance(found.x, np.ndarray)
    assert isinstance(found.best.value, float)


def test_a_phased_driver_is_checked_in_each_phase():
    class Phased:
        limit, starts = 50, 1

        def minimise(self, objective, start, spec):
            return RIGHT

        def descend(self, objective, start, spec, limit, *, free=False):
            return RIGHT

        def polish(self, objective, found, spec, centre, limit):
            return found.x

    with pytest.raises(PluginError, match="'Phased' returns an object of type ndarray"):
        search(Bowl(), START[None], Phased())
    Phased.descend = lambda *_, **__: None
    with pytest.raises(PluginError, match="'Phased' returns an object of type NoneType"):
        search(Bowl(), START[None], Phased())


def test_a_value_that_is_not_the_objective_s_is_refused():
    check_value(Kept(RIGHT), Bowl(), 5.001, 5.0)
    check_value(SIMPLEX.minimiser(), Bowl(), -1e9, 5.0)  # not looked at
    with pytest.raises(PluginError, match=r"returns the value -1e\+09 for an x whose value is 5"):
        check_value(Kept(RIGHT), Bowl(), -1e9, 5.0)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (
            lambda: 1 / 0,
            "fails (ZeroDivisionError: division by zero) in test_driver_answers.py, line ",
        ),
        (lambda: 3, "makes an object of type int without 'minimise'"),
    ],
)
def test_a_driver_that_makes_no_minimiser_is_named(make, said):
    with pytest.raises(PluginError) as caught:
        Driver(make).minimiser()
    assert said in str(caught.value)


def test_a_driver_of_nothing_to_call_is_refused():
    with pytest.raises(PluginError, match="a Driver is made of 3"):
        Driver(3)
