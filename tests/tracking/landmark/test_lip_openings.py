"""The distances between inner lips say how far a mouth is open."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from drawn import CAMERA, anybody, projected
from heads import seen_at

from abs_engine.tracking.detection.landmarks import (
    COUNT,
    INNER_PAIRS,
    INNER_RING,
    OUTER_RING,
    SeenRays,
)
from abs_engine.tracking.landmark import lip_openings
from abs_engine.tracking.landmark.landmark_fit import fit_frame
from abs_engine.tracking.landmark.lip_openings import LipOpenings
from abs_engine.tracking.settings.landmarks import LANDMARK_EVIDENCE

POSE = seen_at([0.05, -0.1, 0.1], [20, -30, 700])
UPPER, LOWER = INNER_PAIRS
MIDDLE = 4  # of the nine


@cache
def average():
    """The landmarks of the average person."""
    return replace(anybody(), identity=anybody().identity[:0])


@cache
def opening():
    """The unit step of a posture (M,) that opens the mouth most."""
    across = (average().posture[:, UPPER] - average().posture[:, LOWER])[..., 1].mean(axis=1)
    return across / np.linalg.norm(across)


@cache
def rest():
    """The mean posture (M,)."""
    return np.zeros(len(opening()))


def points_of(posture):
    return average().mean + np.tensordot(posture, average().posture, 1)


def said(points, posture, shape=None, trust=None, pose=POSE):
    """What is said of a posture by landmarks seen where points (468, 3), mm, are."""
    seen = SeenRays.of(projected(points, pose), CAMERA, trust)
    return LipOpenings.of(average() if shape is None else shape, seen).equations(pose, posture)


def gap(posture):
    """Distance of the inner lips' middles, mm."""
    points = points_of(posture)
    return float(points[UPPER[MIDDLE], 1] - points[LOWER[MIDDLE], 1])


def step_of(found):
    """The step (M,) after which the distances are those that were seen."""
    return -np.linalg.lstsq(found.information, found.gradient, rcond=1e-6)[0]


def thick(points, by):
    """Points whose outer lips lie farther out, mm."""
    out, half = points.copy(), len(OUTER_RING) // 2
    out[OUTER_RING[1:half], 1] -= by
    out[OUTER_RING[half + 1 :], 1] += by
    return out


def in_picture(pose, posture):
    """The distances (9,) along the face in the picture, mm at the pivot, and a pixel there."""
    seen = projected(points_of(posture), pose)
    (right, left), pixel = (
        [seen.pixels[list(pair)].mean(axis=0) for pair in ((33, 133), (263, 362))],
        pose.apply(average().pivot)[2] / CAMERA.matrix[0, 0],
    )
    along = (left - right) / np.linalg.norm(left - right)
    return (seen.pixels[LOWER] - seen.pixels[UPPER]) @ [-along[1], along[0]] * pixel, pixel


@pytest.mark.parametrize(
    ("turn", "away"), [((0.05, -0.1, 0.1), 700), ((0.4, 0.3, 1.4), 350), ((-0.3, -0.6, 0), 2500)]
)
def test_what_is_said_is_how_modes_move_the_lips_apart_over_the_networks_noise(turn, away):
    pose, posture = seen_at(turn, [0, 0, away]), 0.5 * opening()
    (apart, pixel), step = in_picture(pose, posture), 1e-4
    moves = np.stack(
        [
            (in_picture(pose, posture + s)[0] - in_picture(pose, posture - s)[0]) / (2 * step)
            for s in step * np.eye(len(posture))
        ]
    )
    one = LANDMARK_EVIDENCE
    variance = one.opening_least**2 + (one.opening_pixels * pixel) ** 2
    variance = variance + (one.opening_share * np.maximum(apart, 0)) ** 2
    there = pose.apply(points_of(posture))
    sight = there / np.linalg.norm(there, axis=1, keepdims=True)
    facing = -(average().normals @ pose.rotation.T * sight).sum(axis=1)
    shown = np.clip((facing - one.hidden) / (1 - one.hidden), one.guessed, 1.0)
    shown = np.minimum(shown[OUTER_RING[1:10]], shown[OUTER_RING[19:10:-1]])
    weight = shown / variance / one.openings_together
    expected, found = (moves * weight) @ moves.T, said(points_of(posture), posture, pose=pose)
    np.testing.assert_allclose(found.information, expected, atol=1e-2 * np.abs(expected).max())
    np.testing.assert_allclose(found.gradient, 0, atol=1e-6)


@pytest.mark.parametrize("wider", [0.1, -0.1])
def test_a_step_goes_to_the_opening_that_is_seen(wider):
    posture = 0.5 * opening()
    step = step_of(said(points_of((0.5 + wider) * opening()), posture))
    missing = gap((0.5 + wider) * opening()) - gap(posture)
    assert abs(missing) > 0.3
    assert gap(posture + step) - gap(posture) == pytest.approx(missing, rel=0.1)


def test_lips_that_are_seen_thicker_hardly_open_the_mouth(monkeypatch):
    """Without these distances they do, although inner landmarks are seen."""
    seen = projected(thick(points_of(rest()), 3.0), POSE)
    opened = gap(fit_frame(average(), seen, CAMERA).posture) - gap(rest())
    nothing = replace(LANDMARK_EVIDENCE, openings_together=1e12)
    monkeypatch.setattr(lip_openings, "LANDMARK_EVIDENCE", nothing)
    without = gap(fit_frame(average(), seen, CAMERA).posture) - gap(rest())
    assert without > 2.0
    assert abs(opened) < 0.6 * without


def test_one_that_is_far_off_counts_less():
    near, far = (said(points_of(k * opening()), rest()) for k in (0.05, 3.0))
    assert np.linalg.norm(far.gradient) < 20 * np.linalg.norm(near.gradient)  # 60 times as far
    assert np.trace(far.information) < 0.5 * np.trace(near.information)


def test_landmarks_that_are_not_trusted_say_nothing():
    seen, half = points_of(0.2 * opening()), np.full(COUNT, 0.5)
    whole = said(seen, rest())
    np.testing.assert_allclose(said(seen, rest(), trust=half).gradient, 0.5 * whole.gradient)
    none = half.copy()
    none[LOWER] = 0.0
    assert not said(seen, rest(), trust=none).information.any()


@pytest.mark.parametrize("lip", [slice(1, 10), slice(11, 20)])
def test_where_one_lip_faces_away_they_hardly_count(lip):
    normals = average().normals.copy()
    normals[OUTER_RING[lip]] *= -1
    shown, hidden = (
        np.trace(said(points_of(rest()), rest(), shape).information)
        for shape in (average(), replace(average(), normals=normals))
    )
    assert 0 < hidden < 3 * LANDMARK_EVIDENCE.guessed * shown


def test_what_the_network_sees_a_person_off_by_is_taken_off():
    bias = np.zeros((COUNT, 2))
    bias[LOWER, 1] = 1.0
    step = step_of(said(points_of(rest()), rest(), replace(average(), bias=bias)))
    assert gap(step) - gap(rest()) == pytest.approx(-1.0, abs=0.2)


def test_lips_that_overlap_are_as_sure_as_lips_that_touch():
    shut = -gap(rest()) / (gap(opening()) - gap(rest()))
    surely = [
        np.trace(said(points_of(k * opening()), k * opening()).information)
        for k in (0.5 * shut, shut, 1.5 * shut)
    ]
    assert surely[0] < 0.95 * surely[1]
    assert surely[2] == pytest.approx(surely[1], rel=0.05)


def test_a_head_without_postures_says_nothing_and_does_not_fail():
    still = replace(average(), posture=np.zeros((0, COUNT, 3)))
    found = said(points_of(rest()), np.zeros(0), still)
    assert found.information.shape == (0, 0)
    assert found.gradient.shape == (0,)


def test_corners_have_no_opening():
    assert not np.isin(INNER_RING[[0, 10]], INNER_PAIRS).any()
