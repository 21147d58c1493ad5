"""Pose and posture come back from landmarks that were made of known ones."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from drawn import CAMERA, anybody, projected, turned_by
from heads import seen_at

from abs_engine.core.geometry import Pose, rotations
from abs_engine.core.scene import Candidates
from abs_engine.tracking.detection.landmarks import (
    COUNT,
    INNER_RING,
    LIPS,
    MIDDLES,
    OUTER_RING,
    Landmarks,
)
from abs_engine.tracking.detection.mouth_search import shifted
from abs_engine.tracking.frame.mouth_landmarks import LipLandmarks
from abs_engine.tracking.landmark.landmark_fit import FrameLandmarks, HeldPose, fit_frame
from abs_engine.tracking.landmark.landmark_jacobian import weighed_motion
from abs_engine.tracking.settings.landmarks import LANDMARK_EVIDENCE

MODES = 10


@cache
def average():
    """The landmarks of the average person, as sure as if seen to a few tenths of a millimetre."""
    shape = replace(anybody(), identity=anybody().identity[:0])
    return replace(shape, deviation=0.1 * shape.deviation)


def posture_of(seed):
    rng = np.random.default_rng(seed)
    return np.r_[rng.normal(0, 1.0, MODES), rng.normal(0, 0.5, len(anybody().posture) - MODES)]


def pose_of(seed):
    return seen_at(np.random.default_rng(50 + seed).normal(0, 0.2, 3), [20, -30, 700])


def points_of(shape, posture):
    return shape.mean + np.tensordot(posture, shape.posture, 1)


def rms(away):
    """Root mean square length of vectors (..., 3)."""
    return float(np.sqrt((away**2).sum(axis=-1).mean()))


def aligned(one, other):
    """RMS distance of points once size and place are those of the others."""
    a, b = one - one.mean(axis=0), other - other.mean(axis=0)
    return rms((a * b).sum() / (a * a).sum() * a - b)


@pytest.mark.parametrize("seed", range(6))
def test_pose_and_posture_of_a_known_person_come_back(seed):
    shape, pose, posture = average(), pose_of(seed), posture_of(seed)
    points = points_of(shape, posture)
    found = fit_frame(shape, projected(points, pose, noise=0.2, seed=seed), CAMERA)
    assert turned_by(found.pose, pose) < 0.6
    away = found.pose.apply(shape.pivot) - pose.apply(shape.pivot)
    assert np.abs(away[:2]).max() < 0.5
    assert abs(away[2]) < 6.0  # of 700
    lips = (points_of(shape, found.posture) - points)[LIPS]
    assert rms(lips) < 0.3 * rms((points - shape.mean)[LIPS])


def test_noise_of_the_network_pulls_towards_the_usual_posture():
    """With the deviations as they are measured, landmarks outweigh the prior only in part."""
    shape = replace(average(), deviation=10 * average().deviation)
    pose, posture = pose_of(1), posture_of(1)
    seen = projected(points_of(shape, posture), pose)
    unsure, sure = fit_frame(shape, seen, CAMERA), fit_frame(average(), seen, CAMERA)
    assert np.linalg.norm(unsure.posture) < np.linalg.norm(sure.posture)
    truth = points_of(shape, posture)[LIPS]
    assert rms(points_of(shape, unsure.posture)[LIPS] - truth) < rms(shape.mean[LIPS] - truth)


def test_a_start_from_the_frame_before_ends_at_the_same_place():
    shape = average()
    before = fit_frame(shape, projected(points_of(shape, posture_of(3)), pose_of(3)), CAMERA)
    seen = projected(points_of(shape, posture_of(4)), pose_of(4), noise=0.2)
    one, other = (fit_frame(shape, seen, CAMERA, start) for start in (None, before))
    assert turned_by(one.pose, other.pose) < 0.1
    np.testing.assert_allclose(one.posture, other.posture, atol=0.1)


def test_a_few_landmarks_that_are_far_off_hardly_matter():
    shape, posture = average(), posture_of(2)
    seen = projected(points_of(shape, posture), pose_of(2), noise=0.2)
    wrong = seen.points.copy()
    wrong[::40] += np.array([60.0, 40.0, 0.0])
    found = fit_frame(shape, replace(seen, points=wrong), CAMERA)
    assert turned_by(found.pose, pose_of(2)) < 1.0


def test_a_persons_bias_is_taken_off():
    shape = replace(average(), deviation=10 * average().deviation)
    pose, posture = seen_at([0, 0, 0], [0, 0, 700]), posture_of(5)
    seen = projected(points_of(shape, posture), pose)
    along, down = seen.axes
    bias = np.zeros((COUNT, 2))
    bias[INNER_RING[1:10]] = [0.3, 2.0]
    pixel = float(pose.apply(shape.pivot)[2] / CAMERA.matrix[0, 0])
    moved = np.column_stack([bias @ np.stack([along, down]) / pixel, np.zeros(COUNT)])
    biased = replace(seen, points=seen.points + moved)
    right, wrong, without = (
        points_of(shape, fit_frame(one, marks, CAMERA).posture)[INNER_RING]
        for one, marks in ((replace(shape, bias=bias), biased), (shape, biased), (shape, seen))
    )
    assert rms(right - without) < 0.02
    assert rms(wrong - without) > 0.15


def test_what_a_person_is_seen_off_by_becomes_the_bias():
    """Inner lips are seen apart where they meet: only the least open frames tell by how much."""
    shape, pose = average(), seen_at([0.1, 0.2, 0.1], [0, 0, 700])
    rng = np.random.default_rng(0)
    own, off = rng.normal(0, 0.4, (COUNT, 2)), []
    for k in range(8):
        posture = 0.5 * posture_of(k)
        seen = projected(points_of(shape, posture), pose)
        wrong = own + (0.0 if k < LANDMARK_EVIDENCE.closest else 3.0)
        depth = float(pose.apply(shape.pivot)[2]) / CAMERA.matrix[0, 0]
        moved = np.column_stack([wrong @ np.stack(seen.axes) / depth, np.zeros(COUNT)])
        marks = replace(seen, points=seen.points + moved)
        off.append(shape.off(marks, CAMERA, pose, posture))
    known = shape.known(np.full((COUNT, 3), 0.5), off)
    np.testing.assert_allclose(known.mean, shape.mean + 0.5)
    inner = np.isin(np.arange(COUNT), INNER_RING)
    np.testing.assert_allclose(
        known.bias[inner], LANDMARK_EVIDENCE.bias_share * own[inner], atol=0.1
    )
    np.testing.assert_allclose(
        known.bias[~inner], LANDMARK_EVIDENCE.bias_share * (own[~inner] + 3.0), atol=0.1
    )
    np.testing.assert_allclose(
        known.deviation[:, :2], LANDMARK_EVIDENCE.within * shape.deviation[:, :2]
    )
    np.testing.assert_allclose(known.deviation[:, 2], shape.deviation[:, 2])


@pytest.mark.parametrize(("parted", "kept"), [(-3.0, -3.0), (0.8, 0.8), (4.0, 1.0)])
def test_lips_that_never_meet_are_hardly_a_bias(parted, kept):
    """What a fit lags behind open lips is not by how much the network parts closed ones."""
    off = np.zeros((COUNT, 2))
    off[INNER_RING, 1] = 0.4
    off[MIDDLES[1], 1] += parted / 2 / LANDMARK_EVIDENCE.bias_share
    off[MIDDLES[0], 1] -= parted / 2 / LANDMARK_EVIDENCE.bias_share
    bias = average().known(np.zeros((COUNT, 3)), [off] * 8).bias
    assert bias[MIDDLES[1], 1] - bias[MIDDLES[0], 1] == pytest.approx(kept)
    assert bias[INNER_RING, 1].mean() == pytest.approx(0.4 * LANDMARK_EVIDENCE.bias_share)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("sure", [1e12, 1e-12])
def test_a_pose_that_is_held_stays_and_is_part_of_what_is_told(seed, sure):
    shape, pose, posture = average(), pose_of(seed), 0.7 * posture_of(seed)
    marks = projected(points_of(shape, posture), pose, noise=0.2, seed=seed)
    free = fit_frame(shape, marks, CAMERA)
    wrong = shifted(pose, np.array([0.0, 0.02, 0.0, 0.5, 0.0, 0.0]), shape.pivot)
    held = fit_frame(shape, marks, CAMERA, free, HeldPose(wrong, sure * np.eye(6)))
    alone = fit_frame(shape, marks, CAMERA, free, HeldPose(wrong, np.zeros((6, 6))))
    assert turned_by(held.pose, wrong) < 1e-6
    np.testing.assert_allclose(held.pose.translation, wrong.translation, atol=1e-9)
    told = (held.information - alone.information)[:6, :6]
    np.testing.assert_allclose(told, sure * np.eye(6), atol=1e-3 * max(sure, 1.0))


def test_with_a_held_pose_the_posture_is_the_best_there():
    """The gradient by the posture, its prior included, is nothing there, and by the pose is not."""
    shape, pose = average(), pose_of(4)
    marks = projected(points_of(shape, 0.7 * posture_of(4)), pose, noise=0.2)
    wrong = shifted(pose, np.array([0.01, 0.02, 0.0, 0.5, 0.0, 3.0]), shape.pivot)
    found = fit_frame(shape, marks, CAMERA, held=HeldPose(wrong, np.eye(6)))
    pull = found.gradient + np.r_[np.zeros(6), found.posture]
    scale = np.sqrt(np.diag(found.information))
    assert np.abs(pull / scale)[6:].max() < 0.05
    assert np.abs(pull / scale)[:6].max() > 0.5


def toy_frame(seed=0, size=6 + 7):
    rng = np.random.default_rng(seed)
    root = rng.normal(0, 1, (size, 2 * size))
    pose = seen_at([0, 0, 0], [0, 0, 700])
    return FrameLandmarks(
        pose, rng.normal(0, 1, size - 6), root @ root.T, rng.normal(0, 3, size), 1.0
    )


@pytest.mark.parametrize("modes", [0, 3, 7])
def test_the_evidence_is_the_exact_marginal(modes):
    """Of a Gaussian whose other postures are integrated out with their own prior."""
    frame = toy_frame()
    said = frame.evidence(modes)
    kept = np.arange(6 + modes)
    hidden = np.r_[np.zeros(6 + modes), np.ones(7 - modes)]
    start = np.r_[np.zeros(6), frame.posture]
    whole = frame.information + np.diag(hidden)
    mean = start - np.linalg.solve(whole, frame.gradient + hidden * start)
    covariance = np.linalg.inv(whole)[np.ix_(kept, kept)]
    np.testing.assert_allclose(said.information @ covariance, np.eye(len(kept)), atol=1e-6)
    np.testing.assert_allclose(said.mean, mean[kept], atol=1e-3)


def test_with_the_postures_prior_the_evidence_has_its_minimum_at_the_fit():
    shape = replace(average(), deviation=10 * average().deviation)
    frame = fit_frame(shape, projected(points_of(shape, posture_of(1)), pose_of(1)), CAMERA)
    said = frame.evidence(MODES)
    at = np.r_[np.zeros(6), frame.posture[:MODES]]
    deviation = 1 / np.sqrt(np.diag(said.information) + np.r_[np.zeros(6), np.ones(MODES)])

    def value(x):
        return said.negative_log(x) + 0.5 * float(x[6:] @ x[6:])

    for step in deviation * np.eye(6 + MODES):
        slope = (value(at + 1e-3 * step) - value(at - 1e-3 * step)) / 2e-3
        assert abs(slope) < 0.02


def test_information_is_the_curvature_of_the_landmarks_misfit():
    """By finite differences of where they lie, where they are seen just where they are.

    Without the inner lips, so that the distances between them say nothing.
    """
    shape = replace(average(), deviation=10 * average().deviation)
    pose, m = pose_of(2), len(shape.posture)
    frame = replace(
        fit_frame(shape, projected(shape.mean, pose), CAMERA), pose=pose, posture=np.zeros(m)
    )
    seen, trusted = projected(shape.mean, pose), np.ones(COUNT)
    trusted[INNER_RING] = 0.0
    again = fit_frame(shape, seen, CAMERA, frame, trust=trusted)
    assert again.misfit < 0.05

    def off(x):
        turned = rotations(x[None, :3])[0] @ pose.rotation
        place = pose.apply(shape.pivot) + x[3:6] - turned @ shape.pivot
        at = Pose(turned, place)
        flat = shape.off(seen, CAMERA, at, x[6:])
        deep = at.apply(points_of(shape, x[6:]))[:, 2]
        return np.column_stack([flat, deep - deep.mean()]) / shape.deviation

    there = pose.apply(shape.mean)
    sight = there / np.linalg.norm(there, axis=1, keepdims=True)
    facing = -(shape.normals @ pose.rotation.T * sight).sum(axis=1)
    trust = np.clip((facing - 0.15) / 0.85, 0.05, 1.0)
    together = np.full(COUNT, LANDMARK_EVIDENCE.others_together)
    together[INNER_RING], together[OUTER_RING] = (
        LANDMARK_EVIDENCE.inner_together,
        LANDMARK_EVIDENCE.outer_together,
    )
    trust *= trusted / together
    steps = np.diag(np.r_[np.full(3, 1e-4), np.full(3 + m, 1e-2)])
    slope = np.stack([(off(s) - off(-s)) / (2 * s.max()) for s in steps])
    slope[:, LIPS, 2] = 0.0  # depths of lips are left out
    expected = np.einsum("ikd,jkd,k->ij", slope, slope, trust)
    size = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert np.abs((again.information - expected) / size).max() < 0.02


def test_lips_that_lie_off_are_that_far_off():
    shape, pose = average(), seen_at([0, 0, 0.3], [0, 0, 700])
    lips = LipLandmarks.of(shape, MODES, CAMERA)
    posture = posture_of(0)[:MODES]
    points = shape.mean + np.tensordot(posture, shape.posture[:MODES], 1)
    seen = projected(points, pose)
    assert lips.apart(seen, pose, posture)[0] == pytest.approx(0, abs=1e-6)
    moved = Pose(pose.rotation, pose.translation + np.array([3.0, 4.0, 0.0]))
    mm, deviations = lips.apart(seen, moved, posture)
    assert mm == pytest.approx(5.0, rel=0.02)
    assert deviations > 1.0
    biased = replace(shape, bias=np.full((COUNT, 2), 1.5))
    off = LipLandmarks.of(biased, MODES, CAMERA).apart(seen, pose, posture)[0]
    assert off == pytest.approx(1.5 * np.sqrt(2), rel=0.02)


@pytest.mark.parametrize("tall", [0.75, 16 / 15])
def test_lips_lie_as_far_off_where_pixels_are_not_square(tall):
    shape, pose = average(), seen_at([0, 0, 0], [0, 0, 700])
    matrix = CAMERA.matrix * np.array([[1.0], [tall], [1.0]])
    camera = replace(CAMERA, matrix=matrix)
    at = pose.apply(shape.mean)
    seen = Landmarks(np.column_stack([camera.project(at + np.array([0, 3.0, 0])), at[:, 2]]), 1.0)
    off = LipLandmarks.of(shape, MODES, camera).off(seen, Candidates.one(np.zeros(MODES), pose))
    np.testing.assert_allclose(off[0], np.tile([0, -3.0], (len(LIPS), 1)), atol=0.1)


def test_landmarks_move_as_their_weighed_motion_says():
    shape, pose, posture = average(), pose_of(3), posture_of(3)
    rng = np.random.default_rng(1)
    axes, sunk, weight = (
        rng.normal(size=(2, 2)),
        rng.normal(size=COUNT),
        rng.uniform(size=(COUNT, 3)),
    )

    def seen(step):
        moved = shifted(pose, step, shape.pivot).apply(points_of(shape, posture + step[6:]))
        z = moved[:, 2]
        depth = z - sunk * z.mean()
        return np.column_stack([moved[:, :2] / z[:, None] @ axes.T, depth - depth.mean()]) * weight

    there, factor = (
        pose.apply(points_of(shape, posture)),
        1 / pose.apply(points_of(shape, posture))[:, 2],
    )
    out = np.empty((6 + len(posture), 3 * COUNT))
    pivot = pose.apply(shape.pivot)
    weighed_motion(there, pivot, shape.posture, pose.rotation, factor, axes, sunk, weight, out)
    for k, step in enumerate(1e-4 * np.eye(len(out))):
        slope = (seen(step) - seen(-step)) / 2e-4
        np.testing.assert_allclose(out[k], slope.ravel(), rtol=1e-5, atol=1e-6)
