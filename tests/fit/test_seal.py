"""Lips that were found a little apart touch, unless the picture is against it."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.fit.seal import Seal, sealed
from abs_engine.fit.search import Found
from abs_engine.fit.settings import HEAD_FIT
from abs_engine.optimise.base import Solution

SLOPE = np.array([0.0, 2.0, 1.0])
SEEN = np.array([[0.0, 0.0], [0.0, 0.1], [0.0, 0.2], [4.0, 2.0]])


class Picture:
    """A bowl about some parameters, so many nats deep for each squared unit.

    A solver is told of its curvature where it `bends`.
    """

    def __init__(self, best, nats, bends=None):
        self.best, self.nats, self.bends = np.asarray(best), nats, bends

    def chosen(self, x):
        return x

    def whole(self, x):
        return x

    def information(self, x):
        return self.bends

    def __call__(self, x):
        value = self.nats * float(((x - self.best) ** 2).sum())
        return Solution(x, "", value, {}, 1)


def found(picture):
    return Found(picture.best, Solution(picture.best, "converged", 0.0, {}, 10))


@pytest.fixture
def seal():
    return Seal.of(0.1, SLOPE, SEEN, 1.0)


def test_its_odds_are_how_much_oftener_lips_touch(seal):
    assert seal.odds == pytest.approx(np.log(3 * 10.1))
    assert Seal.of(0.1, SLOPE, SEEN[:3], 1.0) is None
    assert Seal.of(0.1, SLOPE, SEEN[3:], 1.0) is None


@pytest.mark.parametrize("bends", [None, np.zeros((3, 3))])
def test_lips_of_anybody_touch_as_in_speech(bends):
    worth = np.log(
        HEAD_FIT.usually_closed
        / (1 - HEAD_FIT.usually_closed)
        * HEAD_FIT.usual_gap
        / HEAD_FIT.resolution
    )
    usual = Seal.usual(0.1, SLOPE)
    assert usual.odds == pytest.approx(worth + np.log(HEAD_FIT.resolution))
    for against, closes in ((0.9 * worth, True), (1.1 * worth, False)):
        nats = against * (SLOPE @ SLOPE) / 0.8**2  # 0.8 mm apart
        picture = Picture([1.0, 0.2, 0.3], nats, bends)
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


def test_lips_touch_where_that_costs_least():
    """A gap is closed by the parameter that the picture leaves free, not by the nearest way."""

    class Held(Picture):
        def __call__(self, x):
            away = x - self.best
            return Solution(x, "", float(away @ self.bends @ away) / 2, {}, 1)

    picture = Held([0.0, 0.1, 0.5], 0.0, np.diag([1.0, 100.0, 1.0]))
    usual = Seal.usual(0.1, SLOPE)
    made = sealed(picture, found(picture), usual)
    assert usual.apart(made.x) == pytest.approx(0.0, abs=1e-9)
    moved = made.x - picture.best
    assert moved[1:] == pytest.approx(-0.8 / (2.0 * 0.02 + 1.0) * np.array([0.02, 1.0]))


@pytest.mark.parametrize(("band", "closes"), [(0.3, True), (3.0, False)])
def test_the_more_gaps_the_picture_leaves_the_more_speaks_for_lips_apart(band, closes):
    """What is compared is what the picture leaves of both cases, by Laplace's method."""
    picture = Picture([0.8], 2.0 / 0.8**2, np.array([[2 * np.pi / band**2]]))
    usual = Seal(0.0, np.array([1.0]), odds=2.0)
    made = sealed(picture, found(picture), usual)
    assert usual.apart(made.x) == pytest.approx(0.0 if closes else 0.8, abs=1e-9)
