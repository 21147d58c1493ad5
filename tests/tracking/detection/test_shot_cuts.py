"""Cuts of a film are found, and what only looks like one is not."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from abs_engine.tracking.detection.shot_cuts import ShotCuts, cut_line

SIZES = [(32, 48), (120, 160), (240, 320), (720, 1280)]


def scene(seed, size=(240, 320)):
    """A picture of soft patches that differ from scene to scene."""
    small = np.random.default_rng(seed).integers(30, 220, (6, 8)).astype(np.float32)
    image = cv2.resize(small, size[::-1], interpolation=cv2.INTER_CUBIC)
    return np.repeat(image[..., None], 3, 2)


def levels(image, noise=0.0, seed=0):
    """The picture with grain, 0 to 255."""
    grain = np.random.default_rng(seed).normal(0, noise, image.shape) if noise else 0.0
    return np.uint8(np.clip(image + grain, 0, 255))


def cuts_of(frames):
    """Frames that begin another shot."""
    cuts = ShotCuts()
    return [k for k, frame in enumerate(frames) if cuts.step(frame)]


@pytest.mark.parametrize("size", SIZES)
def test_another_scene_is_a_cut(size):
    frames = [levels(scene(k, size), 4.0, n) for n, k in enumerate([0, 0, 1, 1, 1, 2])]
    assert cuts_of(frames) == [2, 5]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("noise", [0.0, 8.0])
def test_grain_is_none(size, noise):
    assert cuts_of([levels(scene(0, size), noise, n) for n in range(10)]) == []


def test_light_that_comes_and_goes_is_none():
    picture = scene(0)
    gains = [*np.linspace(0.02, 1, 25), 1.2, 1.2, 0.8, 0.8, *np.linspace(1, 0.02, 25)]
    assert cuts_of([levels(gain * picture, 2.0, n) for n, gain in enumerate(gains)]) == []
    assert cuts_of([levels(picture), levels(picture + 60), levels(picture)]) == []


def test_light_that_moves_from_side_to_side_is_none():
    picture, across = scene(0), np.linspace(-1.0, 1.0, 320)[None, :, None]
    ways = [np.exp(1.5 * side * across) for side in (0, 1, -1, 1, 0)]
    assert cuts_of([levels(0.4 * way * picture, 2.0, n) for n, way in enumerate(ways)]) == []


@pytest.mark.parametrize("noise", [0.0, 4.0])
@pytest.mark.parametrize("level", [0, 100])
def test_plain_pictures_are_none(noise, level):
    plain = np.full((240, 320, 3), level, np.float32)
    assert cuts_of([levels(plain, noise, n) for n in range(10)]) == []


def test_a_cut_through_black_is_found_where_the_picture_returns():
    black = np.zeros((240, 320, 3), np.uint8)
    one, other = (levels(scene(k), 2.0) for k in (0, 1))
    assert cuts_of([one, black, black, other]) == [3]
    assert cuts_of([one, black, black, one]) == []


def test_a_camera_that_is_swung_is_none():
    wide = scene(0, (240, 640))
    assert cuts_of([levels(wide[:, x : x + 320]) for x in range(0, 320, 10)]) == []


@pytest.mark.parametrize("size", SIZES[1:])
def test_a_camera_that_is_shaken_is_none(size):
    high, wide = (round(1.25 * side) for side in size)
    small = np.random.default_rng(0).integers(30, 220, (24, 32)).astype(np.float32)
    whole = np.repeat(cv2.resize(small, (wide, high))[..., None], 3, 2)
    at = (np.random.default_rng(1).uniform(0, 0.25, (20, 2)) * size).astype(int)
    frames = [whole[y : y + size[0], x : x + size[1]] for y, x in at]
    assert cuts_of([levels(frame, 4.0, n) for n, frame in enumerate(frames)]) == []
    other = levels(scene(1, size), 4.0)
    assert cuts_of([*(levels(frame) for frame in frames), other]) == [20]


def test_cuts_are_named():
    assert cut_line([40]).startswith("the film is cut before frame 40: one person")
    line = cut_line([3, 9, 12, 20, 40, 70])
    assert line.startswith("the film is cut before frames 3, 9, 12, 20, 40, ...: ")
