"""Scenes and candidates that cannot be drawn as they are given are refused."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.core.errors import MeshError, ParameterError
from abs_engine.core.scene import Candidates, Scene

PARTS = {
    "mean": [[-9, -9, 0], [9, -9, 0], [0, 9, 0]],
    "modes": np.ones((1, 3, 3)),
    "faces": [[0, 1, 2]],
    "uv": np.zeros((3, 2)),
    "facet_class": [1],
    "texture": np.full((2, 2, 3), 200),
}


def test_whole_numbers_of_any_type_are_taken():
    scene = Scene(**{**PARTS, "facet_class": np.array([2.0])})
    assert scene.texture.max() == 200
    assert scene.highest_class == 2


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("texture", np.full((2, 2, 3), 0.5)),  # of 0 to 1, which would be black
        ("texture", np.full((2, 2, 3), 300)),
        ("texture", np.zeros((0, 0, 3))),
        ("faces", np.array([[0, 1, 2.4]])),
        ("facet_class", [1.5]),
        ("facet_class", [2**40]),
        ("mean", "a"),
    ],
)
def test_what_would_be_cut_off_is_refused(name, given):
    with pytest.raises(MeshError):
        Scene(**{**PARTS, name: given})


def test_weights_and_rotation_vectors_of_another_shape():
    with pytest.raises(ParameterError, match=r"give \(1,\)"):
        Scene(**PARTS).vertices([1, 2])
    for wrong in (np.zeros(3), np.zeros((1, 4))):
        with pytest.raises(ParameterError, match=r"give \(B, 3\)"):
            Candidates.from_vectors(np.zeros((1, 0)), wrong, np.zeros((1, 3)))
