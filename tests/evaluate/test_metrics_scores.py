"""Closures, jitter, poses, pixels, coverage and bootstrap against answers worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import rotations
from abs_engine.evaluate import metrics
from abs_engine.evaluate.metrics import bootstrap
from abs_engine.evaluate.metrics.bootstrap import Mean, confidence, value
from abs_engine.evaluate.score import ClipScores, summary

NAN = float("nan")


def test_error_maps_by_hand():
    found = np.array([[[3.0, 4, 0], [0, 0, 1]], [[0, 0, 0], [0, 7, 0]], [[NAN] * 3] * 2])
    # vertex 0: 5 and 0; vertex 1: 1 and 7; the lost frame does not count
    expected = [np.sqrt(12.5), 5.0]
    np.testing.assert_allclose(metrics.vertex_rms(found, np.zeros((3, 2, 3))), expected)
    squared = metrics.squared_distance(found, np.zeros((3, 2, 3)))
    np.testing.assert_array_equal(squared, [13, 24.5, NAN])


def test_to_head_undoes_to_camera():
    rng = np.random.default_rng(0)
    points, turn, move = (
        rng.normal(size=(4, 5, 3)),
        rng.normal(size=(4, 3)),
        rng.normal(size=(4, 3)),
    )
    there = metrics.to_camera(points, turn, move)
    np.testing.assert_allclose(metrics.to_head(there, turn, move), points, atol=1e-12)


def test_lip_curves_by_hand():
    outer, inner = np.zeros((2, 12, 3)), np.zeros((2, 8, 3))
    outer[:, 0], outer[:, 6] = [-20, 0, 0], [20, 30, 0]  # 50 apart
    outer[:, 3, 2], outer[:, 9, 2] = 100, 90
    inner[:, 2, 1], inner[:, 6, 1] = [8, 1], [3, 2]  # 5 open; overlapping by 1
    curves = metrics.lip_curves(outer, inner)
    np.testing.assert_array_equal(curves["aperture"], [5, 0])
    np.testing.assert_array_equal(curves["width"], [50, 50])
    np.testing.assert_array_equal(curves["protrusion"], [95, 95])


def test_closed_intervals_by_hand():
    np.testing.assert_array_equal(
        metrics.closed_intervals([1, 1, 0, 0, 1, 0, 1, 1, 1]), [[0, 2], [4, 5], [6, 9]]
    )
    assert metrics.closed_intervals(np.zeros(4, bool)).shape == (0, 2)


def test_closures_by_hand():
    #        frame 0  1  2  3  4  5  6  7  8  9 10 11
    true = np.array([0, 1, 1, 0, 0, 0, 1, 1, 1, 0, 1, 0], bool)
    found = np.array([0, 0, 1, 1, 0, 1, 1, 0, 1, 0, 0, 0], bool)
    events = metrics.closure_events(found, true)
    # found [2,4) matches true [1,3); found [5,7) or [8,9) matches true [6,9), one of them only
    assert len(events.pairs) == 2
    onsets = events.onsets[events.onsets[:, 1].argsort()]
    assert (onsets[0, 0], onsets[0, 1]) == (2, 1)
    assert onsets[1, 1] == 6
    assert len(metrics.closure_events(found, np.zeros(12, bool)).pairs) == 0
    begins = metrics.closure_events(np.array([1, 1, 0], bool), np.array([1, 0, 0], bool))
    assert len(begins.pairs) == len(begins.found) == 1
    assert len(begins.onsets) == 0
    with pytest.raises(ParameterError, match="cannot be compared"):
        metrics.closure_events(found, true[1:])


def test_lost_frames_neither_divide_closures_nor_shift_onsets():
    #        frame 0  1  2  3  4  5  6  7  8  9 10 11
    true = np.array([0, 1, 1, 1, 1, 0, 1, 1, 0, 0, 1, 1], bool)
    lost = np.array([0, 0, 0, 1, 0, 1, 0, 0, 0, 1, 1, 0], bool)
    found = true & ~lost
    events = metrics.closure_events(found, true, lost)
    np.testing.assert_array_equal(events.found, [[1, 5], [6, 8], [11, 12]])  # open in frame 5
    assert len(events.pairs) == 3
    np.testing.assert_array_equal(events.onsets, [[1, 1]])
    events = metrics.closure_events(found, true)
    assert len(events.found) == 4
    assert len(events.onsets) == 3


def test_an_onset_is_known_of_both_closures_or_not_at_all():
    #         frame 0  1  2  3  4  5
    early = np.array([1, 1, 1, 1, 0, 0], bool)
    later = np.array([0, 0, 1, 1, 0, 0], bool)
    for found, true in ((early, later), (later, early)):  # one of them begins the clip
        events = metrics.closure_events(found, true)
        assert (len(events.pairs), len(events.onsets)) == (1, 0)


@pytest.mark.parametrize(("away", "onsets"), [(1, []), (2, [[3, 2]])])
def test_an_onset_counts_where_the_truth_is_seen_before_it(away, onsets):
    true, found = np.arange(6) >= 2, np.arange(6) >= 3
    events = metrics.closure_events(found, true, unseen=np.arange(6) == away)
    np.testing.assert_array_equal(events.onsets, np.reshape(onsets, (-1, 2)))


def test_events_are_matched_by_the_largest_total_overlap():
    # The first found closure overlaps with both true ones; greedy in time would waste the second.
    found, true = np.array([[0, 10], [10, 12]]), np.array([[0, 2], [3, 9]])
    np.testing.assert_array_equal(metrics.match_events(found, true), [[0, 1]])


def test_jitter_by_hand():
    true = np.zeros((4, 1, 3))
    found = np.zeros((4, 1, 3))
    found[1, 0] = [3, 0, 4]  # second differences: -2 of it in frame 1, +1 in frame 2
    np.testing.assert_allclose(
        metrics.acceleration_error(found, true, 10.0), [NAN, 2 * 5 * 100, 5 * 100, NAN]
    )
    np.testing.assert_allclose(metrics.noise_level(found, true), [NAN, 100 / 6, 25 / 6, NAN])
    drift = np.arange(5.0)[:, None, None] * np.ones((5, 2, 3))
    assert np.nanmax(metrics.noise_level(drift, np.zeros((5, 2, 3)))) == 0
    with pytest.raises(ParameterError, match="cannot be compared"):
        metrics.noise_level(found, true[1:])


def test_the_noise_level_of_noise_is_its_size():
    noise = np.random.default_rng(1).normal(size=(2000, 5, 3)) * 0.3
    level = np.sqrt(np.nanmean(metrics.noise_level(noise, np.zeros_like(noise))))
    assert level == pytest.approx(0.3 * np.sqrt(3), rel=0.03)


def test_head_angles_by_hand():
    still = np.zeros((3, 3))
    turned = np.array([[0, 0, 0], [0, np.pi / 2, 0], [np.pi, 0, 0]])
    np.testing.assert_allclose(metrics.head_angle(turned, still), [0, 90, 180], atol=1e-6)
    tiny = np.full((1, 3), 1e-9)
    assert 0 < metrics.head_angle(tiny, np.zeros((1, 3)))[0] < 1e-6
    np.testing.assert_array_equal(
        metrics.head_distance([[3, 4, 0], [NAN, 0, 0]], still[:2]), [5, NAN]
    )


@pytest.mark.parametrize("side", ["head", "camera"])
def test_a_constant_turn_is_removed_on_its_own_side_only(side):
    rng = np.random.default_rng(2)
    true = rng.normal(size=(20, 3)) * 0.4
    constant = rotations(np.array([[0.3, -0.2, 0.1]]))[0]
    matrices = rotations(true)
    own = matrices @ constant if side == "head" else constant @ matrices
    found = np.array([_vector(m) for m in own])
    assert metrics.head_angle_without_offset(found, true, side).max() < 1e-5
    other = "camera" if side == "head" else "head"
    assert metrics.head_angle_without_offset(found, true, other).max() > 1
    assert metrics.head_angle(found, true).min() > 15  # |(0.3, -0.2, 0.1)| = 21 degrees


def _vector(matrix):
    import cv2

    return cv2.Rodrigues(matrix)[0].ravel()


def test_pixels_by_hand():
    true = np.zeros((2, 68, 2))
    true[:, 36], true[:, 45] = [-30, 0], [30, 0]
    found = true + np.array([3, 4])
    found[1, 10:] = NAN
    np.testing.assert_array_equal(metrics.interocular(true), [60, 60])
    np.testing.assert_array_equal(metrics.pixel_error(found, true), [25, 25])
    np.testing.assert_allclose(
        metrics.normalised_error(found, true, metrics.interocular(true)), [5 / 60, 5 / 60]
    )
    found[1] = NAN
    assert np.isnan(metrics.pixel_error(found, true)[1])
    with pytest.raises(ParameterError, match="cannot be compared"):
        metrics.pixel_error(found[..., :1], true)


def test_failures_by_hand():
    np.testing.assert_array_equal(metrics.failed([1, 5, 5.1, NAN], 5), [0, 0, 1, 1])


def test_coverage_by_hand():
    low, high = np.array([[0.0, 0], [0, 0], [NAN, 0]]), np.array([[1.0, 1], [1, 1], [1, 1]])
    true = np.array([[0.5, 2], [1, 0], [0.5, 0.5]])
    np.testing.assert_array_equal(metrics.covered(low, high, true), [0.5, 1, NAN])
    with pytest.raises(ParameterError, match="below its beginning"):
        metrics.covered([1.0], [0.0], [0.5])
    with pytest.raises(ParameterError, match="do not fit"):
        metrics.covered([1.0], [2.0], [0.5, 1])


def test_means_by_hand():
    assert value([Mean.of([1, 2, NAN, 3])]) == 2
    assert value([Mean.of([9, 16, 11], root=True)]) == pytest.approx(np.sqrt(12))
    assert value([Mean.of([1, 2]), Mean.of([6])]) == 3  # every frame counts the same
    assert value([Mean.share([1, 0, 1], [1, 1, 0])]) == 0.5
    assert np.isnan(value([Mean.of([NAN])]))
    assert np.isnan(confidence([Mean.of([NAN, NAN])], 25)).all()


def test_block_lengths_by_hand():
    assert metrics.block_length(1000, 25) == 12  # half a second; the cube root is 10
    assert metrics.block_length(27000, 25) == 30  # the cube root
    assert metrics.block_length(20, 25) == 5  # a quarter of the clip
    assert metrics.block_length(1, 25) == 1


def test_confidence_intervals_of_independent_frames_are_the_known_ones():
    values = np.random.default_rng(3).normal(5, 2, size=4000)
    low, high = confidence([Mean.of(values)], rate=2.0, resamples=2000)
    reach = 1.96 * values.std() / np.sqrt(4000)
    assert low == pytest.approx(values.mean() - reach, abs=0.15 * reach)
    assert high == pytest.approx(values.mean() + reach, abs=0.15 * reach)
    assert confidence([Mean.of(values)], 2.0) == confidence([Mean.of(values)], 2.0)
    assert confidence([Mean.of(values)], 2.0) != confidence([Mean.of(values)], 2.0, seed=1)


def test_blocks_widen_the_interval_of_frames_that_hang_together():
    slow = np.repeat(np.random.default_rng(4).normal(size=100), 10)  # 10 alike in a row
    mean = Mean.of(slow)
    low, high = confidence([mean], rate=80.0, resamples=2000)  # blocks of 40 frames
    honest = 2 * 1.96 * slow.std() / np.sqrt(100)
    assert high - low == pytest.approx(honest, rel=0.3)
    assert high - low > 2 * (2 * 1.96 * slow.std() / np.sqrt(1000))


def test_several_clips_are_drawn_whole():
    # Constant within clips: only which clips are drawn matters.
    clips = [Mean.of(np.full(50, k)) for k in (0.0, 0.0, 0.0, 10.0)]
    low, high = confidence(clips, 25.0, resamples=4000)
    # The number of 10s is binomial(4, 1/4): P(0) = 0.316, P(3 or 4) = 0.051, P(4) = 0.004.
    assert (low, high) == (0.0, 7.5)
    assert confidence([Mean.of(np.full(9, 3.0))], 25.0) == (3.0, 3.0)


def test_clips_at_several_rates_are_drawn_in_blocks_of_their_own():
    """The first clip's rate says nothing of the frames of the second."""
    slow = np.repeat(np.random.default_rng(4).normal(size=100), 10)  # 10 alike in a row
    few, many = Mean.of(np.zeros(1)), Mean.of(slow)
    means = {"lip_points_jitter_mm": few}, {"lip_points_jitter_mm": many, "jaw_jitter_mm": many}
    clips = [ClipScores("n", r, m, {}) for r, m in zip((2.0, 80.0), means, strict=True)]
    scores = summary(clips)
    for key, given, rates in (
        ("jaw_jitter_mm", [many], 80.0), ("lip_points_jitter_mm", [few, many], [2.0, 80.0])
    ):  # fmt: skip
        assert (scores[key].low, scores[key].high) == confidence(given, rates)
    bounds = [confidence([many, many], r) for r in (2.0, [2.0, 80.0], 80.0)]
    short, mixed, long = (high - low for low, high in bounds)
    assert short < mixed < long


def test_resampled_clips_have_the_length_of_the_clip():
    mean = Mean.of(np.arange(103.0))
    weight = bootstrap._resampled(mean, 25.0, 50, np.random.default_rng(0))[1]
    np.testing.assert_array_equal(weight, 103)


def test_wrong_seeds_and_rates_are_refused():
    with pytest.raises(ParameterError, match="the seed is -1; give 0 or more"):
        confidence([Mean.of([1.0])], 25.0, seed=-1)
    with pytest.raises(ParameterError, match="2 rates for 3 clips"):
        confidence([Mean.of([1.0])] * 3, [25.0, 30.0])
