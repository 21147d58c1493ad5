"""Metrics against answers worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.core.errors import ParameterError
from abs_engine.evaluate.metrics import (
    Mean,
    closure_events,
    correlation,
    spikes,
    squared_distance,
    to_camera,
    value,
    without_constant_offset,
)
from abs_engine.evaluate.metrics.curves import STABLE, lay_on_rest

NAN = float("nan")


def rms(found, truth):
    """RMS distance of points, mm, over the frames that were tracked."""
    return value([Mean.of(squared_distance(found, truth), root=True)])


def test_rms_by_hand():
    truth = np.zeros((2, 2, 3))
    found = np.array([[[3.0, 4, 0], [0, 0, 0]], [[0, 0, 1], [2, 0, 0]]])
    # frame 0: distances 5 and 0, sqrt(25 / 2); frame 1: 1 and 2, sqrt(5 / 2); all: sqrt(30 / 4)
    np.testing.assert_allclose(squared_distance(found, truth), [12.5, 2.5])
    assert rms(found, truth) == pytest.approx(np.sqrt(7.5))


def test_the_truth_scores_nothing_and_noise_scores_itself():
    rng = np.random.default_rng(0)
    truth = rng.normal(size=(60, 84, 3)) * 20
    assert rms(truth, truth) == 0
    noise = rng.normal(size=truth.shape) * 0.5
    expected = 0.5 * np.sqrt(3)
    assert rms(truth + noise, truth) == pytest.approx(expected, rel=0.02)
    aligned = without_constant_offset(truth + noise, truth)
    assert rms(aligned, truth) == pytest.approx(expected, rel=0.02)


def test_frames_that_were_not_tracked_are_left_out():
    truth = np.zeros((3, 1, 3))
    found = np.array([[[1.0, 0, 0]], [[NAN, 0, 0]], [[0, 7, 0]]])
    assert rms(found, truth) == pytest.approx(5.0)  # sqrt((1 + 49) / 2)
    np.testing.assert_array_equal(squared_distance(found, truth), [1, NAN, 49])
    aligned = without_constant_offset(found, truth)
    assert np.isnan(aligned[1]).any()
    assert np.isfinite(aligned[[0, 2]]).all()


def test_a_constant_rigid_offset_is_removed_and_nothing_else():
    rng = np.random.default_rng(1)
    truth = rng.normal(size=(20, 10, 3)) * 15 + [0, -30, 90]
    moved = to_camera(truth, np.tile([0.1, -0.2, 0.05], (20, 1)), np.tile([4.0, -2, 7], (20, 1)))
    assert rms(moved, truth) > 5
    np.testing.assert_allclose(without_constant_offset(moved, truth), truth, atol=1e-9)


def test_an_offset_that_changes_stays():
    # One point: +1 and -1 mm about the truth in two frames; no constant motion makes that smaller.
    truth = np.zeros((2, 1, 3))
    found = np.array([[[1.0, 0, 0]], [[-1.0, 0, 0]]])
    assert rms(without_constant_offset(found, truth), truth) == pytest.approx(1)


def test_mirrored_points_are_not_mirrored_back():
    truth = np.random.default_rng(2).normal(size=(5, 12, 3)) * 10
    assert rms(without_constant_offset(truth * [-1, 1, 1], truth), truth) > 3


def test_landmarks_are_laid_on_the_person_at_rest_and_never_mirrored():
    rest = np.random.default_rng(3).normal(size=(68, 3)) * 30
    vectors, shifts = np.array([[0.3, -0.5, 0.2], [0, 2, 0]]), np.array([[9.0, 0, 500], [0, 4, 7]])
    moved = to_camera(np.stack([rest, rest]), vectors, shifts)
    np.testing.assert_allclose(lay_on_rest(moved, rest), [rest, rest], atol=1e-9)
    placed = lay_on_rest(moved * [-1, 1, 1], rest)
    assert np.linalg.norm(placed - rest, axis=2)[:, STABLE].mean() > 3


def test_to_camera_by_hand():
    points = np.array([[[1.0, 2, 3]], [[1, 2, 3]]])
    turned = to_camera(points, [[np.pi, 0, 0], [0, 0, np.pi / 2]], [[10, 0, 0], [0, 20, 0]])
    np.testing.assert_allclose(turned, [[[11, -2, -3]], [[-2, 21, 3]]], atol=1e-12)


def test_curves_by_hand():
    assert correlation([1.0, 3, 5, NAN], [0.0, 1, 2, 9]) == pytest.approx(1)
    assert correlation([1.0, 2, 3], [3.0, 2, 1]) == pytest.approx(-1)
    assert np.isnan(correlation([1.0, 2], [3.0, 3]))


def test_spikes_by_hand():
    assert spikes([0, 0, 5, 0, 0, -4, 0], 3) == 2
    assert spikes([0, 5, 5, 0], 3) == 0  # two frames are a movement
    assert spikes([0, 4, 8, 12], 3) == 0  # so is a slope
    assert spikes([0, 3, 0], 3) == 0  # not above the threshold
    assert spikes([9, 0, NAN, 9, 0], 3) == 0
    assert spikes([1.0], 3) == spikes([], 3) == 0


@pytest.mark.parametrize("metric", [squared_distance, without_constant_offset])
def test_points_that_do_not_fit_are_refused(metric):
    with pytest.raises(ParameterError, match="cannot be compared"):
        metric(np.zeros((3, 2, 3)), np.zeros((4, 2, 3)))
    with pytest.raises(ParameterError, match="cannot be compared"):
        metric(np.zeros((3, 2)), np.zeros((3, 2)))
    with pytest.raises(ParameterError, match="no frame was tracked"):
        metric(np.full((3, 2, 3), NAN), np.zeros((3, 2, 3)))


def test_curves_that_do_not_fit_are_refused():
    with pytest.raises(ParameterError, match="cannot be compared"):
        correlation([1, 2], [1, 2, 3])
    with pytest.raises(ParameterError, match="no frame was tracked"):
        correlation([NAN], [1])
    with pytest.raises(ParameterError, match="cannot be compared"):
        closure_events([True], [True, False])
