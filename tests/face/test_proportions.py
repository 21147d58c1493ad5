"""Skulls differ as people's do, whatever the targets would allow; faces as before."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from abs_engine.face.identity import head_modes, identity_shape
from abs_engine.face.shape.proportions import proportioned
from abs_engine.io.assets import load_speaker

SPEAKER = load_speaker()
MARKS = SPEAKER.points["landmark_68"]
V = SPEAKER.vertices
CROWN, BACK = int(V[:, 1].argmax()), int(V[:, 2].argmin())
EARS = int(V[:, 0].argmin()), int(V[:, 0].argmax())


@cache
def modes():
    return head_modes(SPEAKER).astype(np.float64)


def spread(one, other, axis):
    """Standard deviation, mm, of the way between two vertices along an axis."""
    return float(np.linalg.norm(modes()[:, one, axis] - modes()[:, other, axis]))


def test_a_skull_differs_by_millimetres():
    root = MARKS[27]
    assert 6.0 < spread(CROWN, root, 1) < 8.0
    assert 6.0 < spread(root, BACK, 2) < 8.0
    assert spread(CROWN, root, 0) < 3.3
    assert 5.0 < spread(*EARS, 0) < 8.0


def test_a_face_still_differs():
    assert 7.0 < spread(MARKS[8], MARKS[27], 1) < 10.0  # its height
    assert spread(MARKS[36], MARKS[45], 0) > 4.5  # the eyes' distance


def test_what_is_alike_enough_is_left_alone():
    small = 0.01 * identity_shape(SPEAKER).modes(SPEAKER).astype(np.float64)
    flat = small.reshape(len(small), -1)
    tied = proportioned(SPEAKER, flat) @ flat
    np.testing.assert_allclose((tied**2).sum(axis=0), (flat**2).sum(axis=0), rtol=1e-6, atol=1e-12)


def test_a_mask_has_no_skull():
    low = np.minimum(V, [np.inf, V[MARKS[27], 1], np.inf])
    flat = np.random.default_rng(0).normal(size=(3, V.size))
    no_face = replace(SPEAKER, vertices=low, points={})
    np.testing.assert_array_equal(proportioned(no_face, flat) @ flat, flat)
    mask = replace(SPEAKER, vertices=low)
    even = np.ones((1, V.size))
    np.testing.assert_allclose(proportioned(mask, even) @ even, even, rtol=1e-6)
