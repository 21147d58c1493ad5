"""Stretches of a mask, and a few of many things."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.core.arrays import evenly, stretches


@pytest.mark.parametrize(
    ("mask", "found"),
    [("", []), ("000", []), ("111", [[0, 3]]), ("1001101", [[0, 1], [3, 5], [6, 7]])],
)
def test_each_stretch_is_its_first_and_the_one_after_its_last(mask, found):
    assert stretches(np.array([c == "1" for c in mask], bool)) == found


@pytest.mark.parametrize(
    ("count", "most", "chosen"),
    [(0, 4, []), (1, 4, [0]), (3, 20, [0, 1, 2]), (101, 5, [0, 25, 50, 75, 100])],
)
def test_a_few_of_many_things_are_spread_from_the_first_to_the_last(count, most, chosen):
    assert evenly(count, most) == chosen
