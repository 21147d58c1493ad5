"""A drawing put into a picture's light: shading and gloss are found, details are kept."""

from __future__ import annotations

import numpy as np

from abs_engine.tracking.texture.relighting import gray, relit

LAMP = np.array([0.5, -0.5, -0.7]) / np.linalg.norm([0.5, -0.5, -0.7])
VIEW = np.array([0, 0, -1])
HALF = (LAMP + VIEW) / np.linalg.norm(LAMP + VIEW)


def surface(n: int = 4000) -> tuple[np.ndarray, np.ndarray]:
    """A dark, freckled ball before the camera: luminance (N,) and normals (N, 3)."""
    rng = np.random.default_rng(1)
    normals = rng.normal(size=(n, 3))
    normals[:, 2] = -np.abs(normals[:, 2]) - 0.2
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return rng.choice([60.0, 35.0], n, p=[0.8, 0.2]), normals


def lit(drawn: np.ndarray, normals: np.ndarray, gloss: float) -> np.ndarray:
    shine = gloss * np.clip(normals @ HALF, 0, 1) ** 12
    return drawn * (0.3 + 0.9 * np.clip(normals @ LAMP, 0, None)) + shine


def test_shading_and_gloss_are_found():
    drawn, normals = surface()
    seen = lit(drawn, normals, 60)
    found = relit(drawn, seen, normals, np.ones(len(drawn), bool))
    before, after = (np.sqrt(np.mean((shown - seen) ** 2)) for shown in (drawn, found))
    assert after < 0.12 * before


def test_freckles_are_the_drawings_and_not_the_pictures():
    """Light alone does not explain a detail: one that was not drawn is not made."""
    drawn, normals = surface()
    plain = np.full_like(drawn, 60)
    found = relit(plain, lit(drawn, normals, 0), normals, np.ones(len(drawn), bool))
    dark = drawn < 40
    smooth = lit(plain, normals, 0)
    assert abs(np.mean((found / smooth)[dark]) - np.mean((found / smooth)[~dark])) < 0.02


def test_what_is_not_as_drawn_counts_little():
    drawn, normals = surface()
    true = lit(drawn, normals, 60)
    seen, other = true.copy(), np.random.default_rng(0).random(len(true)) < 0.12
    seen[other] = 250
    found = relit(drawn, seen, normals, np.ones(len(drawn), bool))
    assert np.sqrt(np.mean((found - true)[~other] ** 2)) < 5


def test_light_is_found_where_it_is_asked_for_only():
    drawn, normals = surface()
    true = lit(drawn, normals, 60)
    compared = np.arange(len(drawn)) % 3 > 0
    found = relit(drawn, np.where(compared, true, 0), normals, compared)
    assert np.sqrt(np.mean((found - true)[~compared] ** 2)) < 3


def test_a_few_pixels_tell_no_light():
    drawn, normals = surface(300)
    found = relit(drawn, 2 * drawn, normals, np.arange(300) < 20)
    np.testing.assert_array_equal(found, drawn)


def test_green_is_brighter_than_blue():
    picture = np.zeros((1, 2, 3), np.float32)
    picture[0, 0, 1], picture[0, 1, 2] = 100, 100
    np.testing.assert_allclose(gray(picture), [[58.7, 11.4]], atol=0.1)
