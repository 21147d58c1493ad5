"""Chroma that a video holds at half the resolution of its luminance."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from abs_engine.core.camera import Window
from abs_engine.face.appearance.chroma import matched, sampled
from abs_engine.face.appearance.colour_features import features
from abs_engine.face.appearance.luminance import luminance

LIPS, DARK = (160, 100, 96), (20, 13, 12)
REFERENCE = 130.0


def subsampled(picture: np.ndarray) -> np.ndarray:
    """As 4:2:0 video gives it back: one chroma for each square of 2x2 pixels."""
    luma = cv2.cvtColor(picture, cv2.COLOR_RGB2YCrCb)
    height, width = picture.shape[:2]
    small = cv2.resize(luma, (width // 2, height // 2), interpolation=cv2.INTER_AREA)
    luma[..., 1:] = np.repeat(np.repeat(small[..., 1:], 2, axis=0), 2, axis=1)
    return cv2.cvtColor(luma, cv2.COLOR_YCrCb2RGB)


def parted(edge: int) -> np.ndarray:
    """Dark above row `edge`, lips from it on, with the chroma of video."""
    picture = np.empty((40, 32, 3), np.uint8)
    picture[:edge], picture[edge:] = DARK, LIPS
    return subsampled(picture)


def chroma_error(picture: np.ndarray, row: int, colour: tuple[int, int, int] = LIPS) -> float:
    """How far the chromaticity of a row is from what was painted."""
    truth = features(np.array(colour), REFERENCE)[:2]
    return float(np.abs(features(picture, REFERENCE)[row, :, :2] - truth).max())


def test_lips_beside_the_dark_keep_their_colour():
    """Where a square of chroma lies across the edge."""
    picture = parted(21)
    assert chroma_error(matched(picture), 21) < 0.4 * chroma_error(picture, 21)


def test_the_dark_beside_lips_is_hardly_redder():
    picture = parted(21)
    assert chroma_error(matched(picture), 20, DARK) < 0.2 * chroma_error(picture, 20, DARK)


def test_where_no_square_lies_across_the_edge_nothing_is_lost():
    assert chroma_error(matched(parted(20)), 20) < 0.005


def test_luminance_is_that_of_each_pixel():
    picture = np.random.default_rng(3).integers(0, 256, (30, 41, 3)).astype(np.uint8)
    np.testing.assert_allclose(
        luminance(matched(picture)), luminance(picture), rtol=1e-5, atol=1e-3
    )


def test_an_even_picture_stays():
    picture = np.full((9, 9, 3), LIPS, np.uint8)
    np.testing.assert_allclose(matched(picture), picture, rtol=1e-6)
    assert (matched(np.zeros((5, 5, 3), np.uint8)) == 0).all()


@pytest.mark.parametrize(
    "window",
    [
        Window(50.3, 40.7, 30, 20, 2.5),
        Window(20, 10, 90, 70, 0.4),
        Window(40, 30, 50, 40, 0.1),
        Window(-12.5, -7.25, 40, 30, 1.0),
        Window(110, 85, 40, 30, 1.5),
        Window(300, 200, 20, 10, 1.0),
        Window(-90, -60, 20, 10, 1.0),
    ],
    ids=["fine", "coarse", "coarser", "left", "right", "beyond", "before"],
)
def test_a_window_shows_the_matched_picture(window):
    rng = np.random.default_rng(5)
    picture = rng.integers(0, 256, (100, 130, 3)).astype(np.uint8)
    found, whole = sampled(window, picture), window.sample(matched(picture))
    assert found.shape == (window.drawn[1], window.drawn[0], 3)
    np.testing.assert_allclose(found, whole, atol=0.01)
