"""Mirrors against the laws of optics and against pictures worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.optimize import minimize

from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.studio.mirror import Mirror, lines_of_sight
from abs_engine.studio.plane_cut import cut_off

FRONTAL = np.array([[-40, -30, 1000], [40, -30, 1000], [40, 30, 1000], [-40, 30, 1000]], float)
DIAGONAL = Mirror(np.array([[-50, -90, 1050], [50, -90, 950], [50, 90, 950], [-50, 90, 1050]]))
"""In the plane x + z = 1000."""
LENS = Camera(
    np.array([[300, 0, 79.5], [0, 300, 59.5], [0, 0, 1.0]]), (160, 120), np.array([-0.3, 0.1])
)


def test_reflection_in_planes_worked_out_by_hand() -> None:
    points = np.array([[3.0, -7.0, 600.0], [0.0, 0.0, 0.0]])
    assert Mirror(FRONTAL).reflect(points) == pytest.approx(
        np.array([[3, -7, 1400], [0, 0, 2000]]), abs=1e-9
    )
    # x + z = 1000 swaps the two coordinates about it: (x, y, z) -> (1000 - z, y, 1000 - x)
    assert DIAGONAL.reflect(points) == pytest.approx(
        np.array([[400, -7, 997], [1000, 0, 1000]]), abs=1e-9
    )
    assert DIAGONAL.reflect_directions(np.array([0, 0, 1.0])) == pytest.approx([-1, 0, 0])
    assert DIAGONAL.matrix @ DIAGONAL.matrix == pytest.approx(np.eye(4), abs=1e-9)


def test_reflected_point_is_seen_where_the_shortest_path_touches_the_glass() -> None:
    """Fermat: light takes the shortest way from the point over the mirror to the camera."""
    point = np.array([-180.0, 25.0, 950.0])
    corner, across, down = DIAGONAL.corners[0], *(DIAGONAL.corners[[1, 3]] - DIAGONAL.corners[0])

    def glass(at: np.ndarray) -> np.ndarray:
        return corner + at[0] * across + at[1] * down

    def length(at: np.ndarray) -> float:
        return float(np.linalg.norm(glass(at)) + np.linalg.norm(glass(at) - point))

    found = minimize(length, [0.5, 0.5], options={"gtol": 1e-10})
    assert np.all((found.x > 0) & (found.x < 1))
    touched, seen = LENS.project(glass(found.x)), LENS.project(DIAGONAL.reflect(point))
    assert seen == pytest.approx(touched, abs=1e-3)
    assert found.fun == pytest.approx(np.linalg.norm(DIAGONAL.reflect(point)), abs=1e-6)
    column, row = np.rint(seen).astype(int)
    assert DIAGONAL.mask(LENS)[row, column]
    assert DIAGONAL.depth(LENS)[row, column] == pytest.approx(glass(found.x)[2], abs=2.0)


def test_the_mirrors_picture_is_that_of_a_virtual_camera_turned_left_to_right() -> None:
    """A camera at (1000, 0, 1000) that looks along -x sees the world as the diagonal mirror does.

    Its picture is turned left to right, as no rotation makes a reflection.
    """
    camera = Camera.ideal((160, 120), 300.0)
    world_to_virtual = np.array([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]])  # right, down, forward
    pose = Pose(world_to_virtual, -world_to_virtual @ [1000.0, 0, 1000])
    points = np.array([[-180.0, 25.0, 900.0], [-200.0, -40.0, 1020.0]])
    virtual = camera.project(pose.apply(points))
    mirrored = camera.project(DIAGONAL.reflect(points))
    turned = np.column_stack([2 * camera.matrix[0, 2] - virtual[:, 0], virtual[:, 1]])
    assert mirrored == pytest.approx(turned, abs=1e-9)


def test_mask_of_a_frontal_mirror_is_the_rectangle_worked_out_by_hand() -> None:
    camera = Camera.ideal((160, 120), 1000.0)  # 1 px for each mm at 1000 mm; middle at 79.5, 59.5
    expected = np.zeros((120, 160), bool)
    expected[30:90, 40:120] = True  # centres from 29.5 to 89.5 and from 39.5 to 119.5
    assert np.array_equal(Mirror(FRONTAL).mask(camera), expected)
    assert np.array_equal(Mirror(FRONTAL[::-1]).mask(camera), expected)
    depth = Mirror(FRONTAL).depth(camera)
    assert np.all(np.isinf(depth) == ~expected)
    assert depth[expected] == pytest.approx(1000.0)


def test_mask_through_a_lens_agrees_with_its_projected_outline() -> None:
    mirror = Mirror.standing((-60.0, 10.0, 700.0), 0.6, (200.0, 150.0))
    mask, middle = mirror.mask(LENS), mirror.corners.mean(axis=0)
    for scale, inside in ((0.97, True), (1.03, False)):
        corners = middle + scale * (mirror.corners - middle)
        share = np.linspace(0, 1, 32, endpoint=False)[:, None]
        sides = [a + share * (b - a) for a, b in zip(corners, np.roll(corners, -1, 0), strict=True)]
        edge = LENS.project(np.concatenate(sides))
        columns, rows = np.rint(edge).astype(int).T
        seen = (columns >= 0) & (columns < 160) & (rows >= 0) & (rows < 120)
        assert seen.sum() > 60
        assert np.all(mask[rows[seen], columns[seen]] == inside)


def test_lines_of_sight_project_back_onto_pixel_centres() -> None:
    columns, rows = np.meshgrid(np.arange(160), np.arange(120))
    again = LENS.project(lines_of_sight(LENS) * 500.0)
    assert np.abs(again - np.stack([columns, rows], axis=2)).max() < 1e-4


def test_standing_mirror_turns_its_left_edge_towards_the_camera() -> None:
    mirror = Mirror.standing((100.0, 0.0, 800.0), np.radians(30), (60.0, 40.0))
    assert mirror.corners[0] == pytest.approx(
        [100 - 30 * np.cos(np.pi / 6), -20, 800 - 15], abs=1e-9
    )
    assert mirror.normal == pytest.approx([0.5, 0, -np.sqrt(0.75)])
    assert mirror.distance == pytest.approx(800 * np.sqrt(0.75) - 50)


@pytest.mark.parametrize(
    ("corners", "words"),
    [
        (FRONTAL[:3], "shape"),
        (FRONTAL[[0, 0, 2, 3]], "no area"),
        (FRONTAL[[0, 2, 1, 3]], "no rectangle"),
        (np.vstack([FRONTAL[:3], [[-40, 30, 1040]]]), "no rectangle"),
        (FRONTAL * [1, 1, -1], "in front"),
        (np.array([[0, -30, 900], [0, -30, 1000], [0, 30, 1000], [0, 30, 900]]), "edge"),
        (FRONTAL * np.nan, "finite"),
    ],
)
def test_what_is_no_mirror_is_refused(corners: np.ndarray, words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        Mirror(corners)


def test_a_solid_is_cut_off_at_a_plane_that_passes_through_it() -> None:
    """A box of 2 x 3 x 5 is cut at a slant: what is left has half its skin, wound as before."""
    box = trimesh.creation.box((2.0, 3.0, 5.0))
    height = box.vertices @ [0.6, 0.0, 0.8]  # through the middle
    part = cut_off(np.asarray(box.faces, np.int32), height)
    left = trimesh.Trimesh(part.of(box.vertices), part.faces, process=False)
    assert left.area == pytest.approx(box.area / 2)
    assert left.triangles.reshape(-1, 3) @ [0.6, 0, 0.8] == pytest.approx(
        np.maximum(left.triangles.reshape(-1, 3) @ [0.6, 0, 0.8], 0), abs=1e-12
    )
    assert np.all(np.einsum("fc,fc->f", left.face_normals, left.triangles_center) > 0)


def test_a_solid_before_a_plane_is_left_whole_and_one_behind_it_is_gone() -> None:
    box = trimesh.creation.box((2.0, 3.0, 5.0))
    faces = np.asarray(box.faces, np.int32)
    whole = cut_off(faces, box.vertices[:, 2] + 3)
    assert np.array_equal(whole.faces, faces)
    assert np.array_equal(whole.of(box.vertices), box.vertices)
    assert len(cut_off(faces, box.vertices[:, 2] - 3).faces) == 0
