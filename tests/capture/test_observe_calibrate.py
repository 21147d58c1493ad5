"""Cameras and a mirror from pictures of boards that were drawn for them."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from observe_session import BOARD, board_poses
from observed import before_cameras, board_picture, mirror_room, seen_from, two_cameras

from abs_engine.capture.board import Board, Corners
from abs_engine.capture.calibrate import Calibration, calibrate_camera, calibrate_stereo
from abs_engine.capture.mirror import calibrate_mirror
from abs_engine.core.camera import Camera
from abs_engine.core.errors import CalibrationError, ParameterError
from abs_engine.core.geometry import Pose

LENS = Camera(
    np.array([[640.0, 0, 205], [0, 643, 148], [0, 0, 1]]), (400, 300), np.array([-0.2, 0.08])
)
CHESS = Board("chessboard", 9, 7, 20.0)


def held(board: Board, count: int) -> list[Pose]:
    """Board to camera, tilted to all sides half a metre away."""
    rng, middle = np.random.default_rng(4), np.array([board.columns, board.rows, 0])
    out = []
    for _ in range(count):
        turn = Pose.from_vectors(rng.uniform(-0.5, 0.5, 3), np.zeros(3)).rotation
        place = rng.uniform([-25, -20, 440], [25, 20, 560])
        out.append(Pose(turn, place - turn @ (middle * board.square / 2)))
    return out


def found_by(board: Board, pose: Pose, camera: Camera, seed: int = 0) -> Corners:
    """Corners where the camera sees them, off by 0.05 px; without a picture."""
    pixels = camera.project(pose.apply(board.places))
    off = np.random.default_rng(seed).normal(0, 0.05, pixels.shape)
    return Corners(np.arange(len(pixels)), pixels + off, board.places)


@pytest.mark.parametrize("board", [CHESS, Board("charuco", 7, 5, 24.0)])
def test_corners_are_found_where_they_were_drawn(board):
    pose = held(board, 1)[0]
    corners = board.find(board_picture(board, pose, LENS))
    assert corners is not None
    assert len(corners.ids) >= 0.8 * len(board.places)
    away = corners.pixels - LENS.project(pose.apply(corners.places))
    if board.kind == "chessboard":  # the same after half a turn
        turned = LENS.project(pose.apply(board.places[::-1]))
        away = min(away, corners.pixels - turned, key=lambda d: np.abs(d).max())
    assert np.sqrt((away**2).sum(axis=1).mean()) < 0.12
    assert board.find(np.full((300, 400, 3), 90, np.uint8)) is None


def test_a_board_has_no_more_markers_than_its_dictionary():
    for columns, rows in ((10, 10), (9, 11), (7, 14)):
        board = Board("charuco", columns, rows, 24.0)
        drawn = cv2.aruco.CharucoBoard((columns, rows), 24.0, 18.0, board.markers())
        assert len(drawn.getIds()) == columns * rows // 2 <= 50
    with pytest.raises(ParameterError, match=r"52 markers, 4X4_50 has only 50; .* 4X4_1000"):
        Board("charuco", 7, 15, 24.0)
    Board("charuco", 7, 15, 24.0, dictionary="4X4_100")
    Board("chessboard", 20, 20, 24.0)


def test_a_camera_comes_back_from_pictures():
    pictures = [board_picture(CHESS, p, LENS, seed=k) for k, p in enumerate(held(CHESS, 12))]
    corners = [c for c in map(CHESS.find, pictures) if c is not None]
    assert len(corners) >= 9
    done = calibrate_camera(corners, LENS.size)
    assert done.error < 0.1
    off = np.abs(done.camera.matrix[[0, 1], [0, 1]] - [640, 643])
    assert off.max() < 3 * done.focal_deviation < 9
    assert done.camera.matrix[:2, 2] == pytest.approx([205, 148], abs=2.5)
    at = np.array([[-0.2, 0.15, 1.0], [0.25, -0.2, 1.0]])
    assert done.camera.project(at) == pytest.approx(LENS.project(at), abs=2.5)


@pytest.mark.parametrize("tangential", [0.0, 0.02])
def test_tangential_distortion_is_taken_up_where_there_is_some(tangential):
    lens = Camera(LENS.matrix, LENS.size, np.array([-0.2, 0.08, tangential, -tangential]))
    seen = [found_by(CHESS, p, lens, k) for k, p in enumerate(held(CHESS, 12))]
    done = calibrate_camera(seen, lens.size)
    assert done.camera.distortion[2:4] == pytest.approx([tangential, -tangential], abs=2e-3)
    assert (done.camera.distortion[2:4] == 0).all() == (tangential == 0)
    off = np.abs(done.camera.matrix[:2, 2] - lens.matrix[:2, 2])
    assert off.max() < 3 * done.centre_deviation < 6


def test_two_cameras_come_back():
    camera, (_, second) = two_cameras()
    poses = board_poses(before_cameras(), 6)
    pairs = [
        (found_by(BOARD, p, camera, k), found_by(BOARD, seen_from(second, p), camera, 50 + k))
        for k, p in enumerate(poses)
    ]
    pairs[0] = pairs[0][0].at(np.arange(12, 24)), pairs[0][1].at(np.arange(0, 20))  # 8 in common
    one = Calibration(camera, 0.07, 1.0, 1.0, tuple(poses))
    done = calibrate_stereo(pairs, one, one)
    assert done.distance == pytest.approx(np.linalg.norm(second.translation), abs=0.6)
    assert done.error == pytest.approx(0.07, abs=0.03)  # 0.05 px in x and in y
    assert done.pose.rotation == pytest.approx(second.rotation, abs=1e-3)
    assert done.pose.translation == pytest.approx(second.translation, abs=0.6)
    with pytest.raises(CalibrationError, match="2 pairs"):
        calibrate_stereo(pairs[:2], one, one)
    mixed = [(a, b) for (a, _), (_, b) in zip(pairs[1:], pairs[2:] + pairs[1:2], strict=True)]
    with pytest.raises(CalibrationError, match="give pictures of the same moments"):
        calibrate_stereo(mixed, one, one)
    with pytest.raises(CalibrationError, match="both cameras are in the same place"):
        calibrate_stereo([(a, a) for a, _ in pairs], one, one)


def test_a_board_that_hardly_moves_between_both_pictures_is_fine_at_any_size():
    small, (_, second) = two_cameras()
    matrix = np.diag([4.0, 4.0, 1.0]) @ small.matrix
    camera = Camera(matrix, (2560, 2560), small.distortion)
    poses, rng = board_poses(before_cameras(), 6), np.random.default_rng(0)
    moved = [Pose(p.rotation, p.translation + rng.normal(0, 0.5, 3)) for p in poses]
    pairs = [
        (found_by(BOARD, p, camera, k), found_by(BOARD, seen_from(second, q), camera, 50 + k))
        for k, (p, q) in enumerate(zip(poses, moved, strict=True))
    ]
    one = Calibration(camera, 0.07, 1.0, 1.0, tuple(poses))
    done = calibrate_stereo(pairs, one, one)
    assert done.error > 1
    assert done.distance == pytest.approx(np.linalg.norm(second.translation), rel=0.02)


def test_a_mirror_comes_back_from_boards_and_their_images():
    camera, glass, head = mirror_room()
    poses = board_poses(head, 3)
    first = board_picture(BOARD, poses[0], camera, glass)
    direct, image = BOARD.find(first), BOARD.find(first, mirrored=True)
    assert direct is not None
    assert image is not None
    for corners, reflect in ((direct, lambda x: x), (image, glass.reflect)):
        true = camera.project(reflect(poses[0].apply(corners.places)))
        assert np.abs(corners.pixels - true).max() < 0.5
    done = calibrate_mirror([(direct, image)], camera)
    assert done.error < 0.15
    assert done.plane.normal @ glass.normal > np.cos(0.002)
    assert done.plane.distance == pytest.approx(glass.distance, abs=1.5)
    assert done.rectangle @ done.plane.normal == pytest.approx(-done.plane.distance)
    seen = (done.rectangle - glass.corners.mean(axis=0)) @ glass.normal
    assert np.abs(seen).max() < 1.5
    with pytest.raises(CalibrationError, match="ChArUco"):
        calibrate_mirror([], camera)
    bent = Corners(image.ids, image.pixels * [1.0, 1.3], image.places)
    with pytest.raises(CalibrationError, match="no flat mirror"):
        calibrate_mirror([(direct, bent)], camera)


def test_boards_that_stand_alike_are_named():
    flat = [Pose(np.eye(3), np.array([x, -50.0, 500])) for x in (-90.0, -80, -70, -60)]
    with pytest.raises(CalibrationError, match="stands alike"):
        calibrate_camera([found_by(CHESS, p, LENS, k) for k, p in enumerate(flat)], LENS.size)
    with pytest.raises(CalibrationError, match="2 pictures, 3 are needed"):
        calibrate_camera([found_by(CHESS, p, LENS) for p in flat[:2]], LENS.size)


def test_boards_that_are_none_are_named():
    for wrong in (
        {"kind": "dots"}, {"columns": 2}, {"square": 0.0}, {"marker": 30.0}, {"dictionary": "9X9"},
    ):  # fmt: skip
        with pytest.raises(ParameterError):
            Board(**{"kind": "charuco", "columns": 7, "rows": 5, "square": 20.0} | wrong)
