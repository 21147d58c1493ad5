"""Meshes, poses, the camera against OpenCV, windows, parameters."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import MeshError, ParameterError
from abs_engine.core.geometry import FACING, Mesh, Pose, rotations, vertex_normals
from abs_engine.core.params import ParamSpec
from abs_engine.core.pose import PoseFrame

SQUARE = np.array([[0, 0, 0], [2, 0, 0], [2, 3, 0], [0, 3, 0]], float)
HALVES = np.array([[0, 1, 2], [0, 2, 3]])
LENSES = {
    "ideal": [],
    "barrel": [-0.25, 0.08, 0.004, -0.003, 0.01],
    "rational": [-0.25, 0.08, 0.004, -0.003, 0.01, 0.02, -0.01, 0.003],
}


def lens(name: str) -> Camera:
    matrix = np.array([[610.0, 0, 311.5], [0, 590.0, 244.0], [0, 0, 1]])
    return Camera(matrix, (640, 480), np.array(LENSES[name], float))


def test_areas_and_normals():
    mesh = Mesh(SQUARE, HALVES)
    np.testing.assert_allclose(mesh.areas(), [3, 3])
    np.testing.assert_allclose(mesh.normals(), np.tile([0, 0, 1], (4, 1)))


def test_normals_are_weighted_by_area_and_zero_where_there_is_none():
    corner = np.array([[0, 0, 0], [4, 0, 0], [0, 1, 0], [0, 0, 1], [9, 9, 9]], float)
    faces = np.array([[0, 1, 2], [0, 3, 1], [4, 4, 4], [0, 2, 3]])
    normals = vertex_normals(corner, faces)
    np.testing.assert_allclose(normals[0], np.array([1, 4, 4]) / np.sqrt(33))
    np.testing.assert_array_equal(normals[4], 0)


def test_facets_may_be_whole_numbers_of_any_kind():
    for kind in (np.uint16, np.int64, np.float64):
        faces = Mesh(SQUARE, HALVES.astype(kind)).faces
        assert faces.dtype == np.int32
        np.testing.assert_array_equal(faces, HALVES)


@pytest.mark.parametrize("faces", [HALVES + 1, HALVES - 1, HALVES + 10**6])
def test_normals_of_facets_that_point_outside_of_the_vertices_are_refused(faces):
    with pytest.raises(MeshError, match="outside of the 4 vertices"):
        vertex_normals(SQUARE, faces)


def test_no_facets_have_no_normals():
    assert not vertex_normals(SQUARE, np.zeros((0, 3), int)).any()


@pytest.mark.parametrize(
    ("vertices", "faces", "says"),
    [
        (np.where(SQUARE == 3, np.nan, SQUARE), HALVES, "2 mesh vertices are NaN"),
        (np.where(SQUARE == 3, np.inf, SQUARE), HALVES, "NaN or infinite"),
        (SQUARE, HALVES + 1, "outside of the 4 vertices"),
        (SQUARE, HALVES - 1, "outside of the 4 vertices"),
        (SQUARE, HALVES + 2**32, "outside of the 4 vertices"),
        (SQUARE, HALVES + 0.7, "not whole numbers"),
        (SQUARE, np.where(HALVES == 3, np.nan, HALVES), "not whole numbers"),
        (SQUARE, [["a", "b", "c"]], "not whole numbers"),
        (SQUARE, [[0, 1], [0, 1, 2]], "not whole numbers"),
        ([[0, 0, 0], [1, 0]], HALVES, "not three numbers each"),
        (SQUARE, np.zeros((0, 3), int), "outside"),
        (SQUARE * 0, HALVES, "zero area"),
        (SQUARE[:, :2], HALVES, "shapes"),
        (SQUARE, np.array([[0, 1, 2, 3]]), "shapes"),
    ],
)
def test_a_mesh_that_cannot_be_drawn(vertices, faces, says):
    with pytest.raises(MeshError, match=says):
        Mesh(vertices, faces)


def test_rotations_are_those_of_opencv():
    vectors = np.random.default_rng(0).normal(0, 1.2, (20, 3))
    vectors[0] = 0
    ours = rotations(vectors)
    for matrix, vector in zip(ours, vectors, strict=True):
        np.testing.assert_allclose(matrix, cv2.Rodrigues(vector)[0], atol=1e-12)
        np.testing.assert_allclose(rotations(vector[None])[0], matrix, atol=1e-12)


def test_a_pose_and_its_vectors():
    pose = Pose.from_vectors([0.1, -0.4, 0.2], [1, 2, 600])
    np.testing.assert_allclose(pose.rotation_vector, [0.1, -0.4, 0.2], atol=1e-12)
    points = np.random.default_rng(1).normal(0, 50, (4, 5, 3))
    expected = [pose.rotation @ p + pose.translation for p in points.reshape(-1, 3)]
    np.testing.assert_allclose(pose.apply(points).reshape(-1, 3), expected)


def test_the_inverse_of_a_pose_leads_back():
    pose = Pose.from_vectors([0.1, -0.4, 0.2], [1, 2, 600])
    points = np.random.default_rng(1).normal(0, 50, (4, 3))
    np.testing.assert_allclose(pose.inverse.apply(pose.apply(points)), points, atol=1e-9)


def test_small_motions_turn_about_the_pivot():
    pivot = np.array([0.0, -40, 90])
    frame = PoseFrame(Pose.from_vectors([3.0, 0.1, 0], [5, 6, 700]), pivot)
    turned = frame.pose(np.r_[0.2, -0.1, 0.3, 1.0, 2.0, 3.0])
    moved = turned.apply(pivot) - frame.base.apply(pivot)
    np.testing.assert_allclose(moved, [1, 2, 3], atol=1e-9)
    step = Pose.from_vectors([0.2, -0.1, 0.3], np.zeros(3)).rotation  # about the camera's axes
    np.testing.assert_allclose(turned.rotation, step @ frame.base.rotation)


def test_a_facing_head_looks_into_the_camera_and_is_upright():
    pose = Pose.facing(500.0)
    np.testing.assert_array_equal(pose.apply(np.array([10.0, 20, 30])), [10, -20, 470])
    assert np.linalg.det(FACING) == 1


def test_a_pose_that_is_not_finite():
    with pytest.raises(ParameterError, match="NaN"):
        Pose(np.eye(3), [0, np.nan, 1])


@pytest.mark.parametrize("vectors", [([1, 2], [0, 0, 9]), ("turn", [0, 0, 9]), ([0, 0, 0], "far")])
def test_vectors_of_a_pose_that_are_not_three_numbers(vectors):
    with pytest.raises(ParameterError, match="a pose is"):
        Pose.from_vectors(*vectors)


@pytest.mark.parametrize("name", LENSES)
def test_projection_is_that_of_opencv(name):
    camera = lens(name)
    pose = Pose.from_vectors([0.2, -0.1, 0.05], [15, -20, 700])
    points = np.random.default_rng(2).uniform(-150, 150, (200, 3))
    expected, _ = cv2.projectPoints(
        points, pose.rotation_vector, pose.translation, camera.matrix, camera.distortion
    )
    ours = camera.project(pose.apply(points))
    np.testing.assert_allclose(ours, expected[:, 0], atol=1e-6)
    assert camera.distorted == (name != "ideal")


@pytest.mark.parametrize("name", LENSES)
def test_distortion_does_not_fold_back_far_outside_of_the_image(name):
    x = np.linspace(0, 50, 5001)
    points = np.stack([x, 0.3 * x, np.ones_like(x)], axis=1)
    assert (np.diff(lens(name).distort(points)[:, 0]) > 0).all()


@pytest.mark.parametrize("window", [Window(0, 0, 640, 480), Window(100, 50.5, 80, 60, 2.5)])
def test_clip_coordinates_land_on_the_windows_pixels(window):
    camera = lens("ideal")
    points = np.random.default_rng(3).uniform([-60, -60, 400], [60, 60, 900], (50, 3))
    clip = np.c_[points, np.ones(50)] @ camera.clip_matrix(window).T
    unit = clip[:, :3] / clip[:, 3:]
    size = np.array(window.drawn)
    pixel = (unit[:, :2] + 1) / 2 * size - 0.5  # GL: pixel centres lie half a pixel inside
    np.testing.assert_allclose(pixel, window.to_drawn(camera.project(points)), atol=1e-9)
    assert (np.diff(unit[np.argsort(points[:, 2]), 2]) > 0).all()
    ends = np.array([[0, 0, camera.near, 1], [0, 0, camera.far, 1]]) @ camera.clip_matrix(window).T
    np.testing.assert_allclose(ends[:, 2] / ends[:, 3], [-1, 1])


@pytest.mark.parametrize(
    "change",
    [
        {"matrix": np.diag([0.0, 500, 1])},
        {"matrix": np.full((3, 3), np.nan)},
        {"distortion": np.array([np.nan])},
        {"distortion": np.r_[np.zeros(8), 0.1]},
        {"size": (0, 480)},
        {"near": 0.0},
        {"matrix": np.eye(2)},
        {"matrix": np.array([[500.0, 0, 0], [0, 500, 0], [320, 240, 1]])},  # transposed
        {"matrix": 2 * np.array([[500.0, 0, 320], [0, 500, 240], [0, 0, 1]])},
        {"matrix": np.array([[500.0, 0, 320], [0, 500, 240], [0, 0, -1]])},  # of OpenGL
        {"matrix": np.array([[500.0, 3, 320], [0, 500, 240], [0, 0, 1]])},  # skew
        {"matrix": "a"},
        {"distortion": "a"},
        {"size": (512, 512, 3)},
        {"size": (640.0, 480.0)},
        {"size": (float("nan"), 480)},
        {"size": np.array([[640, 480]])},
        {"size": "64"},
        {"size": 512},
        {"size": None},
    ],
)
def test_a_camera_that_cannot_be(change):
    camera = lens("ideal")
    with pytest.raises(ParameterError):
        Camera(**{"matrix": camera.matrix, "size": camera.size, **change})


@pytest.mark.parametrize("kind", [list, np.array, lambda size: tuple(np.array(size, np.int32))])
def test_a_camera_s_size_is_kept_as_two_numbers(kind):
    for camera in (Camera(lens("ideal").matrix, kind((640, 480))), Camera.ideal(kind((640, 480)))):
        assert camera.size == (640, 480)
        assert [type(side) for side in camera.size] == [int, int]


@pytest.mark.parametrize("size", [(512, 512, 3), (64.5, 64), None, 512])
def test_an_ideal_camera_of_a_size_that_is_none(size):
    with pytest.raises(ParameterError, match=r"give width and height, two whole numbers"):
        Camera.ideal(size)


@pytest.mark.parametrize(
    "matrix",
    [
        np.diag([1.0, 1, -1]), -np.eye(3), 2 * np.eye(3), np.zeros((3, 3)),
        np.eye(3) + 0.01 * np.eye(3)[:, [1, 2, 0]], np.diag([1.0, 1, 1.01]),
    ],
)  # fmt: skip
def test_a_pose_turns_and_neither_mirrors_nor_stretches(matrix):
    with pytest.raises(ParameterError, match="no rotation"):
        Pose(matrix, np.zeros(3))
    for vector in np.random.default_rng(0).normal(0, 2, (20, 3)):
        Pose(np.float32(rotations(vector[None])[0]).round(4), np.zeros(3))


def test_poses_and_cameras_keep_what_they_were_made_of():
    rotation, translation = np.eye(3), np.zeros(3)
    matrix, distortion = lens("barrel").matrix.copy(), np.r_[0.1, np.zeros(7)]
    pose, camera = Pose(rotation, translation), Camera(matrix, (640, 480), distortion)
    turned = Pose.from_vectors(np.zeros(3), translation)
    before = [a.copy() for a in (rotation, translation, matrix, distortion)]
    for given in (rotation, translation, matrix, distortion):
        given += 1
    kept = (pose.rotation, pose.translation, camera.matrix, camera.distortion)
    for mine, first in zip(kept, before, strict=True):
        np.testing.assert_array_equal(mine, first)
    np.testing.assert_array_equal(turned.translation, 0)


def test_zero_thin_prism_coefficients_are_no_distortion():
    assert not Camera(np.diag([500.0, 500, 1]), (64, 64), None).distorted
    assert not Camera(np.diag([500.0, 500, 1]), (64, 64), np.zeros(14)).distorted


WINDOWS = [Window(0, 0, 64, 48), Window(10, 6, 20, 12, 3.0), Window(4.5, 3.25, 40, 30, 0.5)]


@pytest.mark.parametrize("window", WINDOWS)
def test_window_coordinates_come_back(window):
    points = np.random.default_rng(4).uniform(-5, 70, (30, 2))
    np.testing.assert_allclose(window.to_image(window.to_drawn(points)), points)


@pytest.mark.parametrize("window", WINDOWS)
def test_the_windows_edges_lie_half_a_pixel_around_its_pixels(window):
    low = np.array([window.x, window.y]) - 0.5
    high = low + np.array([window.width, window.height])
    np.testing.assert_allclose(window.to_drawn(low), [-0.5, -0.5])
    np.testing.assert_allclose(window.to_drawn(high), np.array(window.drawn) - 0.5)


@pytest.mark.parametrize("window", WINDOWS)
def test_samples_are_the_image_where_the_coordinates_say(window):
    """On a ramp, bilinear sampling and averaging give the image coordinate itself."""
    rows, columns = np.mgrid[:48, :64].astype(np.float64)
    width, height = window.drawn
    drawn = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1).astype(float)
    place = window.to_image(drawn)
    inside = (place > 3).all(axis=-1) & (place < [60, 44]).all(axis=-1)
    for axis, ramp in enumerate((columns, rows)):
        sampled = window.sample(ramp)
        assert sampled.shape == (height, width)
        # OpenCV interpolates in steps of 1/32 pixel
        assert np.abs(sampled - place[..., axis])[inside].max() < 0.04


def test_coarse_sampling_averages():
    image = np.zeros((64, 64, 3), np.uint8)
    image[1::4] = 200  # beside the middle of each coarse pixel
    coarse = Window(0, 0, 64, 64, 0.25).sample(image)[2:-2, 2:-2]
    assert np.abs(coarse.astype(float) - 50).max() < 15


def test_an_empty_window():
    with pytest.raises(ParameterError, match="empty"):
        Window(0, 0, 0, 5)


def spec(**change: object) -> ParamSpec:
    whole = {
        "names": ("a", "b"),
        "units": ("mm", "sd"),
        "scale": np.ones(2),
        "lower": np.array([-1.0, -2]),
        "upper": np.array([1.0, 2]),
    }
    return ParamSpec(**(whole | change))


def test_parameters_keep_to_their_bounds():
    np.testing.assert_array_equal(spec().clip(np.array([-3.0, 1.5])), [-1, 1.5])
    assert len(spec()) == 2


@pytest.mark.parametrize(
    "change",
    [
        {"names": ("a",)},
        {"scale": np.ones(3)},
        {"scale": np.array([1.0, 0])},
        {"upper": np.array([1.0, -2])},
    ],
)
def test_a_spec_that_does_not_fit(change):
    with pytest.raises(ParameterError):
        spec(**change)
