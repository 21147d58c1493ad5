"""Chroma that a video holds at half the resolution of its luminance."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from abs_engine.appearance.chroma import matched, sampled
from abs_engine.appearance.colour import features, luminance
from abs_engine.camera import Window

LIPS, DARK, TEETH = (160, 100, 96), (20, 13, 12), (190, 180, 170)
REFERENCE = 130.0


def subsampled(picture: np.ndarray) -> np.ndarray:
    """As 4:2:0 video gives it back: one chroma for each square of 2x2 pixels."""
    luma = cv2.cvtColor(picture, cv2.COLOR_RGB2YCrCb)
    height, width = picture.shape[:2]
    small = cv2.resize(luma, (width // 2, height // 2), interpolation=cv2.INTER_AREA)
    luma[..., 1:] = np.repeat(np.repeat(small[..., 1:], 2, axis=0), 2, axis=1)
    return cv2.cvtColor(luma, cv2.COLOR_YCrCb2RGB)


def parted(edge: int) -> np.ndarray:
    """Dark above, lips below, as video has them: the edge is on a row of pixels."""
    picture = np.empty((40, 32, 3), np.uint8)
    picture[:edge], picture[edge:] = DARK, LIPS
    return subsampled(picture)


def chroma_error(picture: np.ndarray, row: int) -> float:
    """How far the chromaticity of a row of lips is from theirs."""
    truth = features(np.array(LIPS), REFERENCE)[:2]
    return float(np.abs(features(picture, REFERENCE)[row, :, :2] - truth).max())


@pytest.mark.parametrize("edge", [20, 21])
def test_lips_beside_the_dark_keep_their_colour(edge):
    """Where a square of chroma lies across the edge, and where it does not."""
    picture = parted(edge)
    assert chroma_error(matched(picture), edge) < 0.015
    if edge % 2:
        assert chroma_error(picture, edge) > 0.03


def test_luminance_is_that_of_each_pixel():
    picture = np.random.default_rng(3).integers(0, 256, (30, 41, 3)).astype(np.uint8)
    np.testing.assert_allclose(luminance(matched(picture)), luminance(picture), rtol=0.02, atol=1.0)


def test_an_even_picture_stays():
    picture = np.full((9, 9, 3), LIPS, np.uint8)
    np.testing.assert_allclose(matched(picture), picture, rtol=1e-6)
    assert (matched(np.zeros((5, 5, 3), np.uint8)) == 0).all()


@pytest.mark.parametrize(
    "window",
    [
        Window(50.3, 40.7, 30, 20, 2.5),
        Window(20, 10, 90, 70, 0.4),
        Window(-12.5, -7.25, 40, 30, 1.0),
        Window(110, 85, 40, 30, 1.5),
        Window(300, 200, 20, 10, 1.0),
        Window(-90, -60, 20, 10, 1.0),
    ],
    ids=["fine", "coarse", "left", "right", "beyond", "before"],
)
def test_a_window_shows_the_matched_picture(window):
    rng = np.random.default_rng(5)
    picture = rng.integers(0, 256, (100, 130, 3)).astype(np.uint8)
    found, whole = sampled(window, picture), window.sample(matched(picture))
    assert found.shape == (window.drawn[1], window.drawn[0], 3)
    np.testing.assert_allclose(found, whole, atol=0.6)
