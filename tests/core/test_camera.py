"""Rays through pixels of a lens."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.core.camera import Camera

SIZE, CENTRE = (1280, 720), (639.5, 359.5)
WIDE = 790.0, (-0.30, 0.12, 0.0005, -0.0005, -0.02)  # 78 degrees


def camera(focal, distortion):
    matrix = np.array([[focal, 0, CENTRE[0]], [0, focal, CENTRE[1]], [0, 0, 1.0]])
    return Camera(matrix, SIZE, np.array(distortion))


@pytest.mark.parametrize(
    ("focal", "distortion"), [(1100.0, (-0.1, 0.05)), WIDE, (1100.0, (0.25, -0.1)), (900.0, (0.0,))]
)
def test_rays_lead_back_to_their_pixels(focal, distortion):
    one = camera(focal, distortion)
    away = np.array([[[0, 0], [192, -108]], [[-384, 216], [576, 324]]])
    pixels = away + CENTRE
    rays = one.undistort(pixels)
    assert rays.shape == pixels.shape
    back = one.project(np.concatenate([rays, np.ones((2, 2, 1))], axis=2))
    np.testing.assert_allclose(back, pixels, atol=1e-3)


def test_beyond_the_reach_of_a_lens_model_the_lens_is_left_out():
    one = camera(640.0, (-0.33, 0.13, 0, 0, -0.025))  # folds over
    far = np.array([[4000.0, 3000.0], [np.nan, 1.0]])
    np.testing.assert_allclose(one.undistort(far)[0], (far[0] - CENTRE) / 640.0)
    assert np.isnan(one.undistort(far)[1, 0])
    assert one.undistort(np.zeros((0, 2))).shape == (0, 2)
