"""Heads differ as people do: their sides are alike, and none of it is a turn of the head."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial import cKDTree

from abs_engine.face.identity import head_modes, sized_head
from abs_engine.face.shape.population import average_person
from abs_engine.face.shape.smooth import mirrored_modes, smooth_modes
from abs_engine.io.assets import load_speaker

SPEAKER = load_speaker()
V = SPEAKER.vertices.astype(np.float64)
MARKS = SPEAKER.points["landmark_68"][np.r_[8, 17:68]]
OTHER_SIDE = np.array([-1.0, 1.0, 1.0])


@cache
def modes():
    return head_modes(SPEAKER).astype(np.float64)


@cache
def opposite():
    """The vertex that is each one's mirror image."""
    return cKDTree(V).query(V * OTHER_SIDE)[1]


def uneven(some):
    """Modes (K, V, 3) less their mirror images, halved."""
    return 0.5 * (some - some[:, opposite()] * OTHER_SIDE)


def spread(some):
    """Standard deviation at each vertex (V,), mm."""
    return np.sqrt((some**2).sum(axis=(0, 2)))


def test_the_sides_of_a_face_differ_by_a_millimetre_and_faces_by_more():
    brow = SPEAKER.points["landmark_68"][[17, 26]]
    assert spread(uneven(modes()))[brow].max() < 1.0
    assert spread(modes())[brow].min() > 3.0


def turned_by(head):
    """Rotation vector, degrees, that lays the average landmarks on those of a head."""
    from scipy.spatial.transform import Rotation

    a, b = V[MARKS], head[MARKS]
    turn, _ = Rotation.align_vectors(b - b.mean(axis=0), a - a.mean(axis=0))
    return turn.as_rotvec(degrees=True)


def test_the_average_person_is_sized_once():
    person = average_person()
    first, second = sized_head(person, 1.05), sized_head(person, 1.05)
    assert first[0] is second[0]
    assert first[1] is second[1]
    np.testing.assert_allclose(first[0].vertices, 1.05 * person.vertices, rtol=1e-5)


def test_any_other_head_differs_by_its_own_targets():
    sized, modes_of_it = sized_head(SPEAKER, 1.05)
    np.testing.assert_allclose(sized.vertices, 1.05 * SPEAKER.vertices, rtol=1e-5)
    np.testing.assert_array_equal(modes_of_it, head_modes(sized))


def test_a_head_of_another_size_or_person_is_another():
    usual, larger = sized_head(SPEAKER, 1.0), sized_head(SPEAKER, 1.1)
    assert np.abs(larger[0].vertices).max() > 1.09 * np.abs(usual[0].vertices).max()
    sized, none = sized_head(replace(SPEAKER, vertices=2 * SPEAKER.vertices), 0.5, known=True)
    np.testing.assert_allclose(sized.vertices, SPEAKER.vertices, rtol=1e-5)
    assert none.shape == (0, *SPEAKER.vertices.shape)


def test_no_mode_turns_the_face():
    turns = [turned_by(V + 0.2 * mode) for mode in modes()]
    assert np.abs(turns).max() < 0.03
    plain = mirrored_modes(V, 0.1)
    assert max(np.linalg.norm(turned_by(V + 0.2 * mode)) for mode in plain) > 0.2


def test_fields_whose_sides_are_free_are_plain_ones():
    points = np.random.default_rng(0).uniform(-40, 40, (80, 3))
    points = np.concatenate([points, points * OTHER_SIDE])
    scales = [(2.0, 60.0)]
    free, plain = mirrored_modes(points, 1.0, scales), smooth_modes(points, scales)
    ours, theirs = (np.einsum("kvd,kwe->vdwe", m, m) for m in (free, plain))
    np.testing.assert_allclose(ours, theirs, atol=0.05)


@pytest.mark.parametrize("asymmetry", [0.1, 0.5])
def test_fields_are_as_uneven_as_asked_for_and_share_what_plain_ones_share(asymmetry):
    points = np.random.default_rng(1).uniform(20, 60, (60, 3))
    both = np.concatenate([points, points * OTHER_SIDE])
    modes = mirrored_modes(both, asymmetry, [(2.0, 15.0)])
    side, other = modes[:, :60], modes[:, 60:] * OTHER_SIDE
    even, odd = (0.5 * ((side + s * other) ** 2).sum() for s in (1, -1))
    assert np.sqrt(odd / even) == pytest.approx(asymmetry, rel=0.02)
    wide = 3 * 4.0 * (1 + asymmetry**2) / 2
    np.testing.assert_allclose((modes**2).sum(axis=(0, 2)), wide, rtol=0.1)
