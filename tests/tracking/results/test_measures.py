"""Measures against shapes and motions whose numbers are known."""

from __future__ import annotations

import numpy as np
import pytest
from runs import toy_setting

from abs_engine.core.geometry import Pose
from abs_engine.tracking.results.measures import (
    OF_FRAME,
    angles,
    closures,
    enclosed,
    of_frame,
    opening_area,
    velocities,
    velocity,
)

FACING = np.diag([1.0, -1.0, -1.0])


def ellipse(count: int, half_width: float, half_height: float, start: float, end: float):
    """Points (count, 3) on an ellipse from one angle to another, 7 mm before the origin."""
    around = np.linspace(start, end, count)
    x, y = half_width * np.cos(around), half_height * np.sin(around)
    return np.stack([x, y, np.full(count, 7.0)], axis=1)


def about(axis: str, degrees: float) -> np.ndarray:
    """A right-handed turn about an axis of the head."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    first, second = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    turn = np.eye(3)
    turn[[first, first, second, second], [first, second, first, second]] = c, -s, s, c
    return turn


def test_areas_of_an_ellipse():
    contour = ellipse(400, 25, 10, 0, 2 * np.pi)[:-1]
    assert abs(enclosed(contour)) == pytest.approx(np.pi * 250, rel=1e-3)
    upper, lower = ellipse(200, 20, 6, np.pi, 0), ellipse(150, 20, 6, np.pi, 2 * np.pi)
    assert opening_area(upper, lower) == pytest.approx(np.pi * 120, rel=1e-3)


def test_lips_that_overlap_enclose_no_area():
    upper, lower = ellipse(50, 20, -2, np.pi, 0), ellipse(50, 20, -2, np.pi, 2 * np.pi)
    assert opening_area(upper, lower) == 0


def test_velocity_of_even_motion_and_beside_a_gap():
    time = np.array([0, 0.04, 0.09, 0.12, 0.16, 0.2])
    np.testing.assert_allclose(velocity(3 + 50 * time, time, time < 0)[1:-1], 50)
    values = 50 * time
    values[2] = np.nan
    known = np.isfinite(velocity(values, time, time < 0))
    assert known.tolist() == [False, False, False, False, True, False]
    known = np.isfinite(velocity(50 * time, time, time == 0.12))  # another shot
    assert known.tolist() == [False, True, False, False, True, False]


@pytest.mark.parametrize(
    ("axis", "degrees", "expected"),
    [
        ("y", 20, (0, 20, 0)),  # to the subject's left, where x points
        ("x", -15, (15, 0, 0)),  # up: the face's z turns towards y
        ("z", 10, (0, 0, 10)),  # the subject's left side rises: the head falls to the right
    ],
)
def test_angles_of_a_turn_about_one_axis(axis, degrees, expected):
    pose = Pose(FACING @ about(axis, degrees), np.array([0, 0, 600.0]))
    np.testing.assert_allclose(angles(pose), expected, atol=1e-9)


def towards_lens(place: np.ndarray) -> np.ndarray:
    """Rotation of an upright head at a place that looks into the lens: panned and tilted."""
    x, y, z = place
    pan = np.degrees(np.arctan2(x, z))  # to the picture's right, where the head's x points, too
    tilt = np.degrees(np.arctan2(y, np.hypot(x, z)))  # below the lens: the head looks up
    return FACING @ about("y", -pan) @ about("x", -tilt)


@pytest.mark.parametrize("seed", range(20))
def test_angles_are_those_from_looking_into_the_lens_wherever_the_head_is(seed):
    rng = np.random.default_rng(seed)
    place = rng.uniform([-400, -300, 300], [400, 300, 1500])
    pitch, yaw, roll = rng.uniform([-60, -120, -90], [60, 120, 90])
    upright = towards_lens(place)
    np.testing.assert_allclose(upright[:, 2], -place / np.linalg.norm(place), atol=1e-12)
    np.testing.assert_allclose(upright[1, 0], 0, atol=1e-12)  # the eyes are level in the picture
    np.testing.assert_allclose(angles(Pose(upright, place)), (0, 0, 0), atol=1e-9)
    turned = upright @ about("y", yaw) @ about("x", -pitch) @ about("z", roll)
    np.testing.assert_allclose(angles(Pose(turned, place)), (pitch, yaw, roll), atol=1e-9)


def test_a_head_at_the_side_that_looks_along_the_axis_looks_past_the_lens():
    """A picture's right is the subject's left: there the lens lies to the subject's right."""
    pitch, yaw, roll = angles(Pose(FACING, np.array([300.0, 0, 300 * np.sqrt(3)])))
    np.testing.assert_allclose((pitch, yaw, roll), (0, 30, 0), atol=1e-9)


def test_an_unknown_pose_has_no_angles():
    assert np.isnan(angles(None)).all()


def test_closures_have_onset_and_release_between_frames():
    time = np.arange(9) / 10
    aperture = np.array([0.2, 3, 5, 0, 0, 2, np.nan, 0.5, 0.5])
    first, second, third = closures(aperture, time, time < 0)
    assert (first.first, first.last) == (0, 0)
    assert np.isnan(first.onset)  # the clip begins with closed lips
    assert first.release == pytest.approx(0 + 0.1 * 0.8 / 2.8)
    assert (second.onset, second.release) == pytest.approx((0.2 + 0.1 * 4 / 5, 0.4 + 0.1 / 2))
    assert (third.first, third.last) == (7, 8)
    assert np.isnan([third.onset, third.release]).all()
    assert closures(np.full(4, np.nan), time[:4], time[:4] < 0) == []


def test_no_closure_goes_on_in_another_shot():
    time = np.arange(6) / 10
    aperture = np.array([5, 0.5, 0.2, 0.4, 5, 0])
    first, second, third = closures(aperture, time, (time == 0.3) | (time == 0.5))
    assert [(c.first, c.last, c.least) for c in (first, second, third)] == [
        (1, 2, 0.2), (3, 3, 0.4), (5, 5, 0.0)
    ]  # fmt: skip
    assert first.onset == pytest.approx(0.1 * 4 / 4.5)
    assert second.release == pytest.approx(0.3 + 0.1 * 0.6 / 4.6)
    assert np.isnan([first.release, second.onset, third.onset]).all()


def test_a_head_that_opens_its_mouth():
    """Opening the jaw lowers the teeth, widens the gap; a frame without numbers has none."""
    face = toy_setting().face
    rest, wide = (of_frame(face, face.scene.vertices(face.starts[k]), None) for k in (0, 4))
    assert set(rest) == set(OF_FRAME)
    assert rest["jaw_opening"] == 0
    assert wide["jaw_opening"] > 3
    assert wide["opening_area"] > rest["opening_area"] + 100
    assert wide["lip_area"] > wide["opening_area"] + 200
    assert wide["lower_protrusion"] < rest["lower_protrusion"]
    assert np.isnan(list(of_frame(face, None, None).values())).all()


def test_velocities_are_those_of_the_curves_that_are_known():
    time = np.arange(4) / 25
    got = velocities({"width": 3 * time, "jaw_opening": -2 * time}, time, time < 0)
    np.testing.assert_allclose(got["width_velocity"][1:-1], 3)
    np.testing.assert_allclose(got["jaw_velocity"][1:-1], -2)
    assert set(got) == {"width_velocity", "jaw_velocity"}
