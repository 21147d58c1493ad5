"""A search that starts again: its ends are compared by the objective alone."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from abs_engine.core.blocks import POSTURE
from abs_engine.core.objective import Evaluation
from abs_engine.core.params import ParamSpec
from abs_engine.fit.search import Again, search
from abs_engine.optimise.axes import AxesSimplex

START, NEAR, FAR = np.zeros(2), np.array([1.0, 0.0]), np.array([6.0, 0.0])


class TwoBowls:
    """The lower of two bowls, one near the start and one far from it; both have a floor."""

    unit = 1.0
    spec = ParamSpec(("a", "b"), ("sd",) * 2, np.ones(2), np.full(2, -9.0), np.full(2, 9.0))
    blocks = SimpleNamespace(places={POSTURE: slice(0, 2)})

    def __init__(self, near: float, far: float) -> None:
        self.bowls = ((NEAR, near), (FAR, far))

    def _lower(self, x):
        return min(self.bowls, key=lambda bowl: ((x - bowl[0]) ** 2).sum() + bowl[1])

    def __call__(self, x) -> Evaluation:
        middle, floor = self._lower(x)
        return Evaluation(float(((x - middle) ** 2).sum() + floor))

    def values(self, vectors):
        return np.array([self(x).value for x in vectors])

    def gauss_newton(self, x, scale, _difference):
        return self(x).value, np.diag(scale**2), (x - self._lower(x)[0]) * scale

    def whole(self, x):
        return x

    def chosen(self, rows):
        return rows


def found(near: float, far: float):
    """End of a search that is pulled to its start, and starts again beside the far bowl."""
    again = Again(np.array([[5.0, 0.0]]), lambda value: value > 0.1)
    return search(TwoBowls(near, far), START[None], AxesSimplex(300, inertia=0.5), again)


@pytest.mark.parametrize(("near", "far", "taken"), [(0.2, 0.4, NEAR), (0.4, 0.2, FAR)])
def test_of_two_ends_the_lower_is_taken_whatever_pulled(near, far, taken):
    """The pull costs the first end 0.2 and makes it miss its bowl's middle; the second has none."""
    end = found(near, far)
    assert end.again
    assert np.abs(end.x - taken).max() < 1
    assert end.best.value == pytest.approx(TwoBowls(near, far)(end.x).value)
