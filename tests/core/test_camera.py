"""Rays through pixels of a lens."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import ParameterError
from abs_engine.core.lens import unfolded

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


def test_a_ray_is_that_of_its_pixel_or_of_a_camera_without_a_lens():
    """Around the picture too, where OpenCV's search ends at points that are seen elsewhere."""
    one = camera(640.0, (-0.33, 0.13, 0, 0, -0.025))
    pixels = np.stack(np.meshgrid(np.arange(-1500, 2800, 100), np.arange(-1500, 2300, 100)), -1)
    rays = one.undistort(pixels.astype(np.float64))
    back = one.project(np.concatenate([rays, np.ones_like(rays[..., :1])], axis=-1))
    exact = np.abs(back - pixels).max(axis=-1) < 1
    np.testing.assert_allclose(rays[~exact], ((pixels - CENTRE) / 640.0)[~exact])
    middle = (np.abs(pixels - CENTRE) < 300).all(axis=-1)
    assert exact[middle].all()


def test_a_smaller_picture_is_sampled_where_its_camera_sees():
    one, window = camera(*WIDE), Window(0, 0, *SIZE, 0.25)
    points = np.array([[-300.0, 150, 800], [20, -90, 600], [400, 200, 900]])
    seen = window.to_drawn(one.project(points))
    np.testing.assert_allclose(one.scaled(0.25).project(points), seen, atol=1e-9)
    assert one.scaled(0.25).size == window.drawn == (320, 180)


def squared_reach(one):
    """Squared, 1.5 times the largest radius in the picture as OpenCV finds it."""
    width, height = one.size
    corners = np.array([[-1, -1], [width, -1], [-1, height], [width, height]], np.float64)
    flat = cv2.undistortPoints(corners[:, None], one.matrix, one.distortion)[:, 0]
    return float(2.25 * (flat**2).sum(axis=1).max())


@pytest.mark.parametrize(
    ("focal", "distortion", "turns"),
    [
        (790.0, (-0.32, 0.12, 0, 0, -0.02), 1.652),
        (640.0, (-0.1,), np.sqrt(1 / 0.3)),
    ],
)
def test_what_lies_beyond_where_a_lens_turns_back_stays_out_of_the_picture(
    focal, distortion, turns
):
    one = camera(focal, distortion)
    assert np.sqrt(one.radius_limit) == pytest.approx(turns, rel=3e-3)
    assert one.radius_limit < squared_reach(one)
    radii = np.linspace(0, 6, 500)
    seen = one.distort(np.stack([0.6 * radii, 0.8 * radii, np.ones(500)], axis=1))[:, :2]
    assert np.all(np.diff(np.hypot(*seen.T)) > 0)


@pytest.mark.parametrize(
    ("focal", "distortion"),
    [
        (1100.0, (-0.1, 0.05)),
        (790.0, (-0.2, 0.08, 0.001, 0.002)),
        (900.0, (0.25,)),
        (900.0, (0.9, 0.1, 0, 0, 0, 1.25, 0.35, 0.01)),
    ],
)
def test_a_lens_that_does_not_turn_back_reaches_as_far_as_ever(focal, distortion):
    one = camera(focal, distortion)
    assert one.radius_limit == squared_reach(one)


@pytest.mark.parametrize(
    ("distortion", "most", "turns"),
    [
        ((-1 / 3, 0, 0, 0, 0, 0, 0, 0), 1e30, 1.0),  # OpenCV finds no ray, and ends anywhere
        ((-3000, 0, 0, 0, 0, 0, 0, 0), 1e-3, 1 / 9000),  # of a very long lens
        ((0, 0, 0, 0, 0, -1.0, 0, 0), 4.0, 1.0),  # infinite there
        ((0, 0, 0.1, 0.1, 0, 0, 0, 0), 4.0, 4.0),
    ],
)
def test_a_lens_is_used_up_to_where_it_turns_back(distortion, most, turns):
    assert unfolded(np.array(distortion), most) == pytest.approx(turns, rel=0.04)
    assert np.isnan(unfolded(np.array(distortion), np.nan))


@pytest.mark.parametrize("size", [(40_000, 10), (10, 1e9), (np.inf, 10)])
def test_a_window_larger_than_any_picture_is_refused(size):
    with pytest.raises(ParameterError, match="more than 32768 drawn pixels"):
        Window(0, 0, *size)
    with pytest.raises(ParameterError, match="give a smaller size or scale"):
        Window(0, 0, 40, 10, 1000.0)
