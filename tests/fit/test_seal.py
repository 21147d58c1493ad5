"""Lips that were found a little apart touch, unless the picture is against it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest

from abs_engine.fit.seal import Seal, sealed
from abs_engine.fit.search import Found
from abs_engine.fit.settings import HEAD_FIT
from abs_engine.optimise.base import Solution

SLOPE = np.array([0.0, 2.0, 1.0])
SEEN = np.array([[0.0, 0.0], [0.0, 0.1], [0.0, 0.2], [4.0, 2.0]])


class Picture:
    """A bowl about some parameters, so many nats deep for each squared unit."""

    terms: ClassVar = {}

    def __init__(self, best, nats):
        self.best, self.nats = np.asarray(best), nats

    def chosen(self, x):
        return x

    def __call__(self, x):
        value = self.nats * float(((x - self.best) ** 2).sum())
        return Solution(x, "", value, {}, 1)


def found(picture):
    return Found(picture.best, Solution(picture.best, "converged", 0.0, {}, 10))


@pytest.fixture
def seal():
    return Seal.of(0.1, SLOPE, SEEN, 1.0)


def test_its_worth_is_how_much_oftener_lips_touch(seal):
    assert seal.worth == pytest.approx(np.log(3 * 10.1 / HEAD_FIT.resolution))
    assert Seal.of(0.1, SLOPE, SEEN[:3], 1.0) is None
    assert Seal.of(0.1, SLOPE, SEEN[3:], 1.0) is None


def test_lips_of_anybody_touch_as_in_speech():
    worth = np.log(
        HEAD_FIT.usually_closed
        / (1 - HEAD_FIT.usually_closed)
        * HEAD_FIT.usual_gap
        / HEAD_FIT.resolution
    )
    usual = Seal.usual(0.1, SLOPE)
    assert usual.worth == pytest.approx(worth)
    for against, closes in ((0.9 * worth, True), (1.1 * worth, False)):
        picture = Picture([1.0, 0.2, 0.3], against * (SLOPE @ SLOPE) / 0.8**2)  # 0.8 mm apart
        made = sealed(picture, found(picture), usual)
        assert usual.apart(made.x) == pytest.approx(0.0 if closes else 0.8, abs=1e-9)


def test_a_gap_that_the_picture_hardly_shows_is_closed_by_the_least_movement(seal):
    picture = Picture([1.0, 0.2, 0.3], 1.0)
    made = sealed(picture, found(picture), seal)
    assert seal.apart(made.x) == pytest.approx(0)
    moved = made.x - picture.best
    np.testing.assert_allclose(np.cross(moved, SLOPE), 0, atol=1e-12)
    np.testing.assert_array_equal(made.best.x, made.x)
    assert made.best.value == pytest.approx(moved @ moved)
    assert made.best.n_evaluations == 11


def test_a_gap_that_the_picture_shows_stays(seal):
    picture = Picture([1.0, 0.2, 0.3], 1000.0)
    np.testing.assert_array_equal(sealed(picture, found(picture), seal).x, picture.best)


@pytest.mark.parametrize("opening", [-0.2, 2.0])
def test_lips_that_overlap_or_are_wide_open_stay(seal, opening):
    picture = Picture([0.0, opening, 0.0], 0.0)
    assert sealed(picture, found(picture), seal).best.n_evaluations == 10


def test_lips_that_skin_holds_touch_where_that_costs_least():
    """A gap is closed by the parameter that the picture leaves free, not by the nearest way."""

    class Held(Picture):
        terms: ClassVar = {"skin": SimpleNamespace(holds_skin=True)}

        def information(self, x):
            return np.diag([1.0, 100.0, 1.0])

        def whole(self, x):
            return x

        def __call__(self, x):
            away = x - self.best
            return Solution(x, "", float(away @ self.information(x) @ away) / 2, {}, 1)

    picture, usual = Held([0.0, 0.1, 0.5], 0.0), Seal.usual(0.1, SLOPE)
    made = sealed(picture, found(picture), usual)
    assert usual.apart(made.x) == pytest.approx(0.0, abs=1e-9)
    moved = made.x - picture.best
    assert moved[1:] == pytest.approx(-0.8 / (2.0 * 0.02 + 1.0) * np.array([0.02, 1.0]))
