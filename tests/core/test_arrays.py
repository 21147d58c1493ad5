"""Stretches of a mask."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.core.arrays import stretches


@pytest.mark.parametrize(
    ("mask", "found"),
    [("", []), ("000", []), ("111", [[0, 3]]), ("1001101", [[0, 1], [3, 5], [6, 7]])],
)
def test_each_stretch_is_its_first_and_the_one_after_its_last(mask, found):
    assert stretches(np.array([c == "1" for c in mask], bool)) == found
