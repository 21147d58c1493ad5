"""Whose head it is, and what its millimetres rest on."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from drawn import (
    CAMERA,
    average_shape,
    correspondence,
    projected,
    speaker,
    vertices_of,
)
from heads import seen_at

from abs_engine.face.identity import head_modes, identity_shape
from abs_engine.face.settings.shape import SHAPE
from abs_engine.face.shape.mouth import mouth_units
from abs_engine.face.shape.population import average_person
from abs_engine.face.shape.proportions import proportioned
from abs_engine.face.shape.smooth import mirrored_modes, smooth_modes
from abs_engine.face.shape.upper_face import upper_face_modes
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.head.head_fit import AverageHead
from abs_engine.tracking.head.head_problem import HeadFrameSeen
from abs_engine.tracking.person.scale import pupil_distance, pupil_scale

TURNS = np.linspace(-0.3, 0.3, 8)


def test_a_scaled_speaker_moves_as_much_more():
    one = speaker()
    larger = one.scaled(1.1)
    np.testing.assert_allclose(larger.vertices, 1.1 * one.vertices, rtol=1e-5)
    names = ("jawOpen", "mouthPucker")
    moved, wanted = larger.unit_matrix(names), 1.1 * one.unit_matrix(names)
    np.testing.assert_allclose(moved, wanted, atol=0.04)  # of half floats
    assert np.abs(moved).max() > 10
    np.testing.assert_allclose(larger.named("mei"), 1.1 * one.named("mei"), atol=0.05)
    assert pupil_distance(larger, larger.vertices) == pytest.approx(
        1.1 * pupil_distance(one, one.vertices), rel=1e-5
    )


def seen_of(person, noise=0.0):
    """What a network that errs by `noise` mm would see of a person, in as many frames as usual."""
    points = correspondence().of(vertices_of(person))
    return [
        projected(points, seen_at([0, yaw, 0], [0, 0, 700]), noise=noise, seed=k)
        for k, yaw in enumerate(TURNS)
    ]


@cache
def unbiased():
    """What a network that errs on no side would be taken for."""
    one = correspondence()
    return replace(one, noise=replace(one.noise, bias=0 * one.noise.bias))


def fitted(landmarks, pupils, camera=CAMERA):
    """By landmarks alone: in pictures without texture."""
    empty = np.full(camera.size[::-1], 90, np.uint8)
    frames = [HeadFrameSeen(empty, marks, None) for marks in landmarks]
    average = AverageHead.of(speaker(), unbiased(), pupil_scale(pupils), average_shape())
    return average.fitted(frames, camera, CpuRenderer())


def test_only_a_person_of_whom_nothing_is_known_may_move_by_the_units_of_scans():
    units = len(mouth_units())
    for head, known, generators in (
        (average_person(), False, 2 * units),
        (average_person(), True, units),
        (replace(speaker()), False, units),  # a file of one's own, another mesh perhaps
    ):
        average = AverageHead.of(head, correspondence(), pupil_scale(None), known=known)
        assert average.expression.mixing.shape[1] == generators


@cache
def found_of(person, pupils=None):
    return fitted(seen_of(person, 0.3), pupils)


def test_the_average_head_is_found_average():
    """Its mouth's modes have a mean of their own, which postures take back."""
    own = pupil_distance(speaker(), speaker().vertices)
    found = fitted(seen_of(None), own)
    assert np.abs(found.identity).max() < 0.35
    assert np.sqrt(np.mean(found.identity**2)) < 0.1
    away = np.linalg.norm(found.neutral - speaker().vertices, axis=1)
    assert np.median(away) < 1.0


@pytest.mark.parametrize("person", ["mei", "walter"])
def test_a_person_is_found_as_large_as_the_pupils_say(person):
    truth = vertices_of(person)
    pupils = pupil_distance(speaker(), truth)
    found = fitted(seen_of(person, 0.3), pupils)
    assert pupil_distance(found.speaker, found.neutral) == pytest.approx(pupils, rel=0.03)
    points = correspondence().of(found.neutral), correspondence().of(truth)
    sizes = [np.linalg.norm(p - p.mean(axis=0), axis=1).mean() for p in points]
    assert sizes[0] == pytest.approx(sizes[1], rel=0.05)
    off = points[0] - points[0].mean(axis=0) - points[1] + points[1].mean(axis=0)
    average = correspondence().of(speaker().vertices)
    other = average - average.mean(axis=0) - points[1] + points[1].mean(axis=0)
    assert np.sqrt((off**2).sum(axis=1).mean()) < 0.75 * np.sqrt((other**2).sum(axis=1).mean())


def test_all_of_it_is_as_large_as_the_pupils_say():
    small, large = found_of("clara", 55.0), found_of("clara", 66.0)
    assert large.scale.pupils == 66.0
    for found in (small, large):
        apart = pupil_distance(found.speaker, found.neutral)
        assert apart == pytest.approx(found.scale.pupils, abs=0.5)
    sizes = [np.linalg.norm(np.std(f.neutral, axis=0)) for f in (small, large)]
    assert sizes[1] / sizes[0] == pytest.approx(1.2, rel=0.03)
    spans = [np.linalg.norm(f.expression.modes) for f in (small, large)]
    assert spans[1] / spans[0] == pytest.approx(1.2, rel=0.01)
    assert len(large.textured.shape.identity) == 0
    assert len(large.textured.shape.posture) == SHAPE.expression_modes + len(
        upper_face_modes(speaker())
    )


def test_directions_of_people_are_targets_of_the_speaker_and_pairs_are_one():
    one = speaker()
    shape = identity_shape(one)
    assert len(set(shape.names)) == len(shape.names)
    assert set(shape.names) <= set(one.identity_names)
    used = (shape.weights != 0).sum(axis=0)
    np.testing.assert_array_equal(used, 1)  # every target belongs to just one direction
    pairs = (shape.weights != 0).sum(axis=1)
    assert set(pairs) <= {1, 2}
    for row in shape.weights[pairs == 2]:
        more, less = np.sort(row[row != 0])[::-1]
        assert more == -less > 0
    k = shape.names.index(next(n for n in shape.names if n.endswith("mouth-scale-horiz-incr")))
    wider = shape.modes(one)[k][one.landmarks["mouth_corners"]]
    assert wider[:, 0].max() > 0 > wider[:, 0].min()


def test_directions_of_heads_are_those_of_targets_and_of_smooth_fields():
    """Principal directions: the variance of all points is that of both together, less a little.

    As far as proportions of the skull leave it, and without what turns a face.
    """
    one = speaker()
    modes, targets = head_modes(one), identity_shape(one).modes(one)
    free = np.concatenate([targets, mirrored_modes(one.vertices.astype(float), 0.1)])
    both = proportioned(one, free.reshape(len(free), -1)) @ free.reshape(len(free), -1)
    assert 0.6 < (both**2).sum() / (free.astype(float) ** 2).sum() < 0.9
    kept, whole = ((m.astype(float) ** 2).sum() for m in (modes, both))
    assert 0.97 * whole < kept < whole
    lengths = (modes.astype(float) ** 2).sum(axis=(1, 2))
    assert (np.diff(lengths) <= 1e-3).all()


def test_smooth_fields_have_the_kernel_that_was_asked_for():
    points = np.random.default_rng(0).uniform(-40, 40, (60, 3))
    modes = smooth_modes(points, [(2.0, 50.0)])
    covariance = np.einsum("kvd,kwe->vwde", modes, modes)
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    wanted = 4.0 * np.exp(-0.5 * (apart / 50.0) ** 2)
    np.testing.assert_allclose(covariance[..., 1, 1], wanted, atol=0.02)
    np.testing.assert_allclose(covariance[..., 0, 1], 0.0, atol=1e-9)


def test_a_pair_is_named_by_what_it_adds():
    one, shape = speaker(), identity_shape(speaker())
    for name, row in zip(shape.names, shape.weights, strict=True):
        assert row[one.identity_names.index(name)] > 0


def test_targets_and_modes_say_the_same():
    one, shape = speaker(), identity_shape(speaker())
    identity = np.random.default_rng(0).normal(0, 1, len(shape.names))
    by_targets = one.person((identity @ shape.weights).astype(np.float32)) - one.vertices
    by_modes = np.tensordot(identity, shape.modes(one), 1)
    np.testing.assert_allclose(by_targets, by_modes, atol=0.01)
    eyes = [pupil_distance(one, one.person(shape.weights[k])) for k in range(len(identity))]
    spread = np.sqrt(np.sum((np.array(eyes) - pupil_distance(one, one.vertices)) ** 2))
    assert 0.03 < spread / pupil_distance(one, one.vertices) < 0.09  # as in people


def test_the_upper_face_moves_without_the_mouth():
    one = speaker()
    moved = np.linalg.norm(upper_face_modes(one), axis=2).max(axis=0)
    lips = moved[one.lip_ring].max()
    assert moved.max() > 2.0
    assert lips < 0.5 * moved.max()
    few = replace(one, unit_names=one.unit_names[:3], units=one.units[:3])
    assert len(upper_face_modes(few)) == 3  # of those that it asks for
