"""Whose head it is, and what its millimetres rest on."""

from __future__ import annotations

from dataclasses import asdict, replace
from functools import cache

import numpy as np
import pytest
from drawn import (
    CAMERA,
    average_shape,
    correspondence,
    lit,
    network_sees,
    projected,
    speaker,
    vertices_of,
)
from heads import seen_at

from abs_engine.camera import Camera
from abs_engine.errors import ParameterError
from abs_engine.shape.identity import identity_shape
from abs_engine.shape.upper_face import upper_face_modes
from abs_engine.track.head_fit import (
    PUPILS_SPREAD,
    USUAL_PUPILS,
    fit_head,
    known_scale,
    pupil_distance,
    pupil_scale,
    scale_line,
    scaled,
)

TURNS = (-0.3, 0.0, 0.3)


def test_a_pupil_distance_that_is_given_is_taken_as_it_is():
    found = pupil_scale(58.0)
    assert found.pupils == 58.0
    assert found.source == "pupil distance"
    assert 0 < found.uncertainty < 0.01


def test_the_usual_one_says_how_far_people_differ():
    found = pupil_scale(None)
    assert found.pupils == USUAL_PUPILS
    assert found.uncertainty == pytest.approx(PUPILS_SPREAD / USUAL_PUPILS)
    assert 0.05 < found.uncertainty < 0.07


@pytest.mark.parametrize("given", [5.0, 29.9, 90.1, -60.0, 6.3, np.nan, np.inf])
def test_what_is_no_pupil_distance_is_refused(given):
    with pytest.raises(
        ParameterError, match="is not a plausible pupil distance; give millimetres"
    ) as told:
        pupil_scale(given)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize("given", [30.0, 90.0])
def test_the_ends_are_taken(given):
    assert pupil_scale(given).pupils == given


def test_the_scale_is_said_in_a_line():
    usual = scale_line(asdict(pupil_scale(None)))
    assert usual == "scale: usual pupil distance, pupils 63.4 mm apart, ± 6%"
    given = scale_line(asdict(pupil_scale(61.0)))
    assert given == "scale: pupil distance, pupils 61.0 mm apart, ± 1%"
    known = scale_line(asdict(known_scale(62.25, person=True, poses=False)))
    assert known == "scale: known head, pupils 62.2 mm apart"


def test_a_head_that_is_not_fitted_has_its_own_scale():
    assert known_scale(60.0, person=True, poses=True).source == "known head"
    assert known_scale(60.0, person=False, poses=True).source == "given poses"
    average = known_scale(60.0, person=False, poses=False)
    assert average.source == "average head"
    assert average.pupils == 60.0
    assert average.uncertainty > 0.05


def test_a_scaled_speaker_moves_as_much_more():
    one = speaker()
    larger = scaled(one, 1.1)
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
    """What a network that errs by `noise` mm would see of a person from three sides."""
    points = correspondence().of(vertices_of(person))
    return [
        projected(points, seen_at([0, yaw, 0], [0, 0, 700]), noise=noise, seed=k)
        for k, yaw in enumerate(TURNS)
    ]


def fitted(landmarks, pupils, camera=CAMERA):
    return fit_head(
        speaker(), correspondence(), landmarks, camera, pupil_scale(pupils), average_shape()
    )


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
    found = fit_head(
        speaker(), correspondence(), seen_of(person, 0.3), CAMERA, pupil_scale(pupils),
        average_shape(),
    )  # fmt: skip
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
    np.testing.assert_allclose(large.neutral, 1.2 * small.neutral, atol=1e-3)
    for name in ("mean", "modes"):
        one, other = (getattr(f.expression, name) for f in (small, large))
        np.testing.assert_allclose(other, 1.2 * one, atol=2e-3)
    for name in ("mean", "pivot"):
        one, other = (getattr(f.shape, name) for f in (small, large))
        np.testing.assert_allclose(other, 1.2 * one, atol=2e-2)
    np.testing.assert_allclose(large.identity, small.identity)
    assert len(large.shape.identity) == 0
    assert len(large.shape.posture) == 10 + len(upper_face_modes(speaker()))


def test_the_eyes_are_as_far_apart_as_the_network_sees_them():
    """Of a drawn person as an unknown one, at the true pupil distance: about the true depth."""
    camera = Camera.ideal((320, 320))
    pupils = pupil_distance(speaker(), vertices_of("amara"))
    marks = [network_sees(lit("amara", seen_at([0, yaw, 0], [0, 0, 700]), camera)) for yaw in TURNS]
    found = fitted(marks, pupils, camera)
    lips = found.neutral[found.speaker.lip_ring]
    true = vertices_of("amara")[speaker().lip_ring]
    assert np.ptp(lips[:, 0]) == pytest.approx(np.ptp(true[:, 0]), rel=0.15)
    assert found.scale.source == "pupil distance"


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


def test_a_pair_is_named_by_what_it_adds():
    one, shape = speaker(), identity_shape(speaker())
    for name, row in zip(shape.names, shape.weights, strict=True):
        assert row[one.identity_names.index(name)] > 0


def test_targets_and_modes_say_the_same():
    one, shape = speaker(), identity_shape(speaker())
    identity = np.random.default_rng(0).normal(0, 1, len(shape.names))
    by_targets = one.person(shape.targets(identity)) - one.vertices
    by_modes = np.tensordot(identity, shape.modes(one), 1)
    np.testing.assert_allclose(by_targets, by_modes, atol=0.01)
    eyes = [
        pupil_distance(one, one.person(shape.targets(np.eye(len(identity))[k])))
        for k in range(len(identity))
    ]
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
