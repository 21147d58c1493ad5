"""Details of a drawing in a picture, and the pose that puts them there."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from heads import seen_at

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.tracking.texture.feature_matching import Drawn, match, pose_of_matches

CAMERA = Camera.ideal((640, 480))
ALL = np.ones((160, 200), bool)


def texture(seed: int = 0) -> np.ndarray:
    noise = np.random.default_rng(seed).normal(size=(160, 200)).astype(np.float32)
    return 128 + 200 * cv2.GaussianBlur(noise, (0, 0), 3)


def shifted(picture: np.ndarray, x: float, y: float) -> np.ndarray:
    move = np.array([[1, 0, x], [0, 1, y]], np.float64)
    return cv2.warpAffine(picture, move, picture.shape[::-1], flags=cv2.INTER_CUBIC)


def drawn(picture: np.ndarray) -> Drawn:
    return Drawn(picture, ALL, ALL, 150.0)


# ---- matches -------------------------------------------------------------------------------------


def test_details_are_found_where_they_are_in_other_brightness_and_contrast():
    picture = texture()
    found = match(drawn(picture), 40 + 0.5 * shifted(picture, 3.3, -2.6), 0.05)
    assert len(found.at) > 40
    away = found.found - found.at
    np.testing.assert_allclose(np.median(away, axis=0), [3.3, -2.6], atol=0.1)
    assert np.abs(away - [3.3, -2.6]).max() < 0.5


def test_agreement_tells_the_right_place_from_another():
    picture = texture()
    assert match(drawn(picture), 0.5 * picture, 0.05).agreement > 0.99
    assert match(drawn(picture), texture(1), 0.05).agreement < 0.2


def test_details_are_looked_for_within_the_reach_only():
    picture = texture()
    found = match(drawn(picture), shifted(picture, 15, 0), 0.05)
    assert np.abs(found.found - found.at).max() < 0.05 * 150 + 1
    found = match(drawn(picture), shifted(picture, 15, 0), 0.12)
    np.testing.assert_allclose(np.median(found.found - found.at, axis=0), [15, 0], atol=0.1)


def test_nothing_is_found_on_a_plain_surface():
    found = match(drawn(np.full((160, 200), 90, np.float32)), texture(), 0.05)
    assert (len(found.at), found.agreement) == (0, -1.0)


def test_only_what_is_wanted_and_wholly_drawn_is_looked_for():
    picture, half = texture(), np.arange(200) < 100
    wanted = np.broadcast_to(half, ALL.shape)
    found = match(Drawn(picture, ALL, wanted, 150.0), picture, 0.05)
    assert found.at[:, 0].max() < 100
    found = match(Drawn(picture, wanted, ALL, 150.0), picture, 0.05)
    assert found.at[:, 0].max() < 95


def test_what_patches_reach_over_is_near():
    wanted = np.zeros(ALL.shape, bool)
    wanted[70:90, 90:110] = True
    one = Drawn(texture(), ALL, wanted, 150.0)
    rows, columns = np.nonzero(one.near)
    assert rows.min() <= 70 - one.half
    assert columns.max() >= 109 + one.half
    assert rows.min() > 70 - 2 * one.half
    assert len(match(one, texture(), 0.05).at) > 3


def test_a_stripe_is_sharply_placed_across_and_not_along():
    rows = np.arange(160, dtype=np.float32)[:, None]
    stripe = 200 - 150 * np.exp(-(((rows - 80) / 3) ** 2))
    picture = stripe + 0.02 * (texture() - 128)
    found = match(drawn(picture.astype(np.float32)), picture.astype(np.float32), 0.05)
    information = np.swapaxes(found.root, 1, 2) @ found.root
    near = np.abs(found.at[:, 1] - 80) < 8
    assert near.sum() > 10
    assert (information[near, 1, 1] > 10 * information[near, 0, 0]).all()


# ---- pose ----------------------------------------------------------------------------------------


@pytest.fixture
def points() -> np.ndarray:
    rng = np.random.default_rng(2)
    flat = rng.uniform([-60, -50, 80], [60, 60, 80], (60, 3))
    flat[:, 2] -= 0.004 * (flat[:, :2] ** 2).sum(axis=1)
    return flat


TRUE = seen_at([0.1, -0.3, 0.05], [12, -8, 600])
SHARP = np.tile(2 * np.eye(2), (60, 1, 1))


def solved(points, motions, pixels, k=0) -> tuple[Pose, np.ndarray]:
    start = seen_at([0, -0.2, 0], [5, 0, 630]), np.zeros(k)
    return pose_of_matches(points, motions, pixels, SHARP, CAMERA, start)


def test_the_pose_comes_back_in_spite_of_wrong_matches(points):
    pixels = CAMERA.project(TRUE.apply(points))
    pixels[::6] += np.random.default_rng(0).uniform(-25, 25, (10, 2))
    pose, weights = solved(points, np.zeros((60, 0, 3)), pixels)
    assert np.degrees(pose.angle_to(TRUE)) < 0.3
    np.testing.assert_allclose(pose.apply(points), TRUE.apply(points), atol=1.5)
    assert weights.shape == (0,)


def test_raised_brows_are_told_from_a_raised_head(points):
    motions = np.zeros((60, 1, 3))
    motions[points[:, 1] > 25, 0, 1] = 2.0  # mm upwards
    raised = points + 1.5 * motions[:, 0]
    pixels = CAMERA.project(TRUE.apply(raised))
    pose, weights = solved(points, motions, pixels, 1)
    stiff, _ = solved(points, np.zeros((60, 0, 3)), pixels)
    assert np.degrees(pose.angle_to(TRUE)) < 0.3 < np.degrees(stiff.angle_to(TRUE))
    np.testing.assert_allclose(weights, [1.5], atol=0.25)
