"""Triangulation and the head frame, against points that were put there."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.capture.dot_annotations import LIPS17
from abs_engine.capture.head import HeadChoice, head_motion
from abs_engine.capture.headframe import mouth_axes, rigid_motion
from abs_engine.capture.triangulate import triangulate
from abs_engine.capture.view import Plane, View
from abs_engine.core.camera import Camera
from abs_engine.core.errors import (
    DegenerateViewsError,
    ParameterError,
    TooFewPointsError,
)
from abs_engine.core.geometry import Pose
from abs_engine.studio.mirror import Mirror

CAMERA = Camera(
    np.array([[900.0, 0, 330], [0, 905, 235], [0, 0, 1]]), (640, 480), np.array([-0.2, 0.06, 0.001])
)
MIRROR = Mirror.standing((152, 0, 609), -1.07, (260, 300))
SECOND = Pose.from_vectors([0.02, 0.5, -0.01], [-250.0, 10, 80])
POINTS = np.random.default_rng(1).uniform([-40, -60, 560], [40, 60, 640], (3, 20, 3))


def two_views() -> tuple[list[View], np.ndarray]:
    pixels = np.stack([CAMERA.project(POINTS), CAMERA.project(SECOND.apply(POINTS))])
    return [View(CAMERA), View(CAMERA, SECOND)], pixels


def test_points_come_back_from_two_cameras_with_distortion():
    views, pixels = two_views()
    made = triangulate(views, pixels)
    assert made.points == pytest.approx(POINTS, abs=1e-5)
    assert made.error.max() < 1e-6


def test_points_come_back_from_a_mirror():
    away = POINTS - [100, 0, 0]
    pixels = np.stack([CAMERA.project(away), CAMERA.project(MIRROR.reflect(away))])
    made = triangulate([View(CAMERA), View(CAMERA, mirror=Plane.through(MIRROR.corners))], pixels)
    assert made.points == pytest.approx(away, abs=1e-5)


def test_the_virtual_camera_stands_where_the_mirror_shows_it():
    view = View(CAMERA, mirror=Plane.through(MIRROR.corners))
    linear, offset = view.motion
    assert -linear.T @ offset == pytest.approx(MIRROR.reflect(np.zeros(3)), abs=1e-9)


def test_reprojection_error_of_a_disagreement_worked_out_by_hand():
    """Rows that differ by 2 d leave d px to each of two views that differ by a shift along x."""
    camera = Camera.ideal((640, 480), 1000.0)
    beside = Pose(np.eye(3), np.array([-300.0, 0, 0]))
    point = np.array([[150.0, 0.0, 600.0]])
    pixels = np.stack([camera.project(point), camera.project(beside.apply(point))])
    pixels[1, 0, 1] += 3.0
    made = triangulate([View(camera), View(camera, beside)], pixels)
    assert made.error[0] == pytest.approx(1.5, abs=1e-3)


def test_a_point_that_one_view_lacks_has_no_place():
    views, pixels = two_views()
    pixels[1, 0, 4] = np.nan
    made = triangulate(views, pixels)
    assert np.isnan(made.points[0, 4]).all()
    assert made.known.sum() == made.known.size - 1


def test_lines_of_sight_that_cross_behind_the_cameras_make_no_point():
    camera = Camera.ideal((640, 480), 1000.0)
    behind = np.array([[0.0, 0.0, -600.0]])
    beside = Pose(np.eye(3), np.array([-300.0, 0, 0]))
    pixels = np.stack([camera.project(behind), camera.project(beside.apply(behind))])
    assert not triangulate([View(camera), View(camera, beside)], pixels).known.any()


def test_views_along_one_line_are_named():
    near = Pose(np.eye(3), np.array([-5.0, 0, 0]))
    pixels = np.stack([CAMERA.project(POINTS), CAMERA.project(near.apply(POINTS))])
    with pytest.raises(DegenerateViewsError, match="leaves depth open"):
        triangulate([View(CAMERA), View(CAMERA, near)], pixels)
    with pytest.raises(ParameterError, match="two views"):
        triangulate([View(CAMERA)], pixels[:1])


def test_a_mistaken_point_does_not_hide_views_along_one_line():
    near = Pose(np.eye(3), np.array([-5.0, 0, 0]))
    pixels = np.stack([CAMERA.project(POINTS), CAMERA.project(near.apply(POINTS))])
    pixels[1, 0, 3] += [150.0, 0]
    with pytest.raises(DegenerateViewsError, match="leaves depth open"):
        triangulate([View(CAMERA), View(CAMERA, near)], pixels)


def test_a_point_whose_depth_is_open_has_no_place():
    views, pixels = two_views()
    far = np.array([0.0, 0, 9000])
    pixels[:, 1, 2] = CAMERA.project(far[None])[0], CAMERA.project(SECOND.apply(far[None]))[0]
    sight = views[0].directions(pixels[0, 1, 2][None]), views[1].directions(pixels[1, 1, 2][None])
    assert np.degrees(np.arccos((sight[0] * sight[1]).sum())) < 3
    made = triangulate(views, pixels)
    assert np.isnan(made.points[1, 2]).all()
    assert made.known.sum() == made.known.size - 1


RIGID = np.array([[0.0, 0, 0], [60, 0, 0], [0, 80, 0], [10, 20, 40]])


def moving(points: np.ndarray, frames: int = 6) -> tuple[np.ndarray, list[Pose]]:
    rng = np.random.default_rng(2)
    poses = [Pose.from_vectors(rng.normal(0, 0.3, 3), rng.normal(0, 50, 3)) for _ in range(frames)]
    return np.stack([p.apply(points) for p in poses]), poses


def test_the_heads_pose_comes_back():
    seen, poses = moving(RIGID)
    motion = rigid_motion(seen, RIGID)
    assert motion.rotations == pytest.approx(np.stack([p.rotation_vector for p in poses]))
    assert motion.translations == pytest.approx(np.stack([p.translation for p in poses]))
    assert motion.to_head(seen) == pytest.approx(np.tile(RIGID, (6, 1, 1)))
    assert motion.error == pytest.approx(0, abs=1e-9)


def test_a_wrong_reference_turns_all_frames_alike():
    """Its errors do not come back as motion of the lips."""
    seen, poses = moving(RIGID)
    lips = np.stack([p.apply(np.array([[20.0, -70, 30]])) for p in poses])
    wrong = RIGID + np.random.default_rng(3).normal(0, 2, RIGID.shape)
    seen[3, 1] = np.nan  # with a point lacking, too
    laid = rigid_motion(seen, wrong).to_head(lips)[:, 0]
    assert np.ptp(laid, axis=0) == pytest.approx(0, abs=1e-6)
    assert np.linalg.norm(laid[0] - [20, -70, 30]) > 0.5


@pytest.mark.parametrize("wrong", [RIGID / 10, RIGID * [-1, 1, 1], RIGID[[1, 0, 2, 3]]])
def test_a_reference_of_another_unit_or_with_sides_exchanged_is_refused(wrong):
    names = "abcd"
    seen, _ = moving(RIGID)
    seen[2, 1] = np.nan
    measured = RIGID + np.random.default_rng(3).normal(0, 2, RIGID.shape)
    right = HeadChoice(names, dict(zip(names, measured, strict=True)))
    assert head_motion(seen, names, right).found.all()
    choice = HeadChoice(names, dict(zip(names, wrong, strict=True)))
    with pytest.raises(ParameterError, match=r"the rigid points lie [0-9]+ mm RMS off the ref"):
        head_motion(seen, names, choice)


def test_frames_with_too_few_rigid_points_have_no_head():
    seen, _ = moving(RIGID)
    seen[2, :2] = np.nan
    motion = rigid_motion(seen, RIGID)
    assert motion.found.tolist() == [True, True, False, True, True, True]
    assert np.isnan(motion.to_head(seen)[2]).all()


def test_rigid_points_that_leave_a_rotation_open_are_named():
    line = np.array([[0.0, 0, 0], [30, 0, 0], [90, 0.5, 0]])
    with pytest.raises(DegenerateViewsError, match="one line"):
        rigid_motion(moving(line)[0])
    with pytest.raises(TooFewPointsError, match="2 rigid points"):
        rigid_motion(moving(line)[0][:, :2])
    seen = moving(RIGID)[0]
    seen[:, 0] = np.nan
    with pytest.raises(TooFewPointsError, match="no frame"):
        rigid_motion(seen)


def mouth() -> np.ndarray:
    """17 points with x to the left and y up, and four of the skull."""
    at = np.zeros((21, 3))
    across = np.array([-10.0, 0, 10])
    at[0], at[4] = [-20, 0, 0], [20, 0, 0]
    at[1:4] = np.stack([across, np.full(3, 6.0), np.zeros(3)], axis=1)
    at[5:8] = np.stack([across, np.full(3, -6.0), np.zeros(3)], axis=1)
    at[16] = [0, 40, 15]
    at[17:] = RIGID + np.array([0, 60, -40])
    return at


NAMES = (*LIPS17, "a", "b", "c", "d")


def test_axes_of_a_mouth_that_is_turned():
    turn = Pose.from_vectors([0.4, -0.8, 0.3], [5.0, 6, 7])
    axes = mouth_axes(turn.apply(mouth()), NAMES)
    assert axes @ turn.rotation == pytest.approx(np.eye(3), abs=1e-12)
    with pytest.raises(TooFewPointsError, match="corner_right"):
        mouth_axes(mouth()[1:], NAMES[1:])


def test_without_a_reference_the_head_frame_is_that_of_the_mouth_and_nose():
    seen, _ = moving(mouth())
    motion = head_motion(seen, NAMES, HeadChoice(rigid=("a", "b", "c", "d")))
    assert motion.to_head(seen) == pytest.approx(
        np.tile(mouth() - mouth()[16], (6, 1, 1)), abs=1e-8
    )


def test_a_head_that_is_only_shifted():
    shifts = np.array([[0.0, 0, 0], [3, 4, 5], [-1, 0, 2]])
    seen = mouth() + shifts[:, None]
    motion = head_motion(seen, NAMES, HeadChoice(unturned="nose"))
    assert motion.to_head(seen) == pytest.approx(np.tile(mouth() - mouth()[16], (3, 1, 1)))


@pytest.mark.parametrize(
    ("choice", "error", "match"),
    [
        (HeadChoice(), TooFewPointsError, "nose alone"),
        (HeadChoice(rigid=("a", "b")), TooFewPointsError, "2 rigid points"),
        (HeadChoice(rigid=("a", "b", "x")), ParameterError, "no point 'x'"),
        (HeadChoice(rigid=("a", "b", "c"), unturned="nose"), ParameterError, "several ways"),
    ],
)
def test_choices_that_do_not_fix_the_head_are_named(choice, error, match):
    with pytest.raises(error, match=match):
        head_motion(moving(mouth())[0], NAMES, choice)
