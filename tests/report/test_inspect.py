"""Inspection pictures: their colours, their light, their layout, from truth known beforehand."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
import trimesh
from inspected import bodies

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import FACING, Pose
from abs_engine.core.scene import Candidates, Scene
from abs_engine.io.assets import load_speaker
from abs_engine.render.cpu import CpuRenderer
from abs_engine.report.drawing import palette
from abs_engine.report.drawing.paint import AMBIENT, LAMP, Coat, paint, value_coat
from abs_engine.report.drawing.smooth import smooth_picture
from abs_engine.report.drawing.view import View, views_of
from abs_engine.report.drawing.wire import line_cover, quad_edges
from abs_engine.report.inspect.body import coat
from abs_engine.report.inspect.labels import drawn_labels


def square(right: float) -> Scene:
    """A white square in the camera frame at z = 1, x from -2 to `right` and y from -2 to 2."""
    corners = np.array([[-2, -2, 1], [right, -2, 1], [right, 2, 1], [-2, 2, 1]], np.float32)
    return Scene(
        corners,
        np.zeros((0, 4, 3), np.float32),
        np.array([[0, 2, 1], [0, 3, 2]], np.int32),
        np.zeros((4, 2), np.float32),
        np.ones(2, np.int32),
        np.full((1, 1, 3), 255, np.uint8),
        cull=False,
    )


def smooth_square(renderer) -> np.ndarray:
    """A picture of 9x9 pixels at 1 pixel a mm: the square ends a sixth into pixel column 5."""
    camera = Camera(np.array([[1, 0, 4], [0, 1, 4], [0, 0, 1.0]]), (9, 9), near=0.1)
    one = Candidates.one(np.zeros(0), Pose(np.eye(3), np.zeros(3)))
    return smooth_picture(renderer, square(0.5 + 1 / 3), one, camera, camera.whole)


def test_a_pixel_is_white_as_far_as_it_is_covered():
    # Column 4 spans x of -0.5 to 0.5, column 5 that of 0.5 to 1.5: a third of it is covered.
    row = smooth_square(CpuRenderer())[4, :, 0]
    assert row == pytest.approx([0, 0, 127.5, 255, 255, 85, 0, 0, 0], abs=45)
    assert row[[3, 4]] == pytest.approx([255, 255])
    assert row[5] == pytest.approx(85, abs=1)


@pytest.mark.gl
def test_opengl_multisamples(renderer):
    row = smooth_square(renderer)[4, :, 0]
    assert row[[0, 3, 4, 7]].tolist() == [0, 255, 255, 0]
    assert row[5] == pytest.approx(85, abs=70)
    assert 0 < row[5] < 255


@pytest.mark.gl
def test_both_renderers_make_the_same_picture(renderer):
    body = bodies()[1]
    (view,) = views_of(body.vertices, (96, 108))
    made = [paint(r, body, coat(body, "clay"), view).astype(int) for r in (renderer, CpuRenderer())]
    assert np.abs(made[0] - made[1]).mean() < 0.5


def test_light_is_lamberts():
    body, colour = bodies()[0], np.array([200, 100, 50])
    plain = Coat(
        np.full((len(body.vertices), 2), 0.5, np.float32), colour.astype(np.uint8)[None, None]
    )
    (view,) = views_of(body.vertices, (128, 144))
    picture = paint(CpuRenderer(), body, plain, view)
    shaded = drawn_labels(CpuRenderer(), body, view)
    normals, ids = shaded.read("normals"), shaded.ids
    inner = cv2.erode((ids > 0).astype(np.uint8), np.ones((3, 3))) > 0
    facing = np.clip(normals @ (LAMP / np.linalg.norm(LAMP)), 0, 1)
    expected = (AMBIENT + (1 - AMBIENT) * facing)[..., None] * colour
    assert np.median(np.abs(picture - expected)[inner]) < 2
    assert (picture[ids == 0][:5] == 255).all()


def test_values_are_painted_in_the_colours_of_their_scale():
    scale = np.stack([np.arange(256)] * 3, axis=1).astype(np.uint8)
    body = bodies()[0]
    x = body.vertices[:, 0]
    (view,) = views_of(body.vertices, (96, 108))
    picture = paint(CpuRenderer(), body, value_coat(x, (-80, 80), scale), view, ambient=1.0)
    buffers = CpuRenderer().draw(
        Scene(
            body.vertices, np.zeros((0, *body.vertices.shape)), body.speaker.faces,
            body.speaker.uv, body.speaker.facet_class, scale[None],
        ),
        Candidates.one(np.zeros(0), view.pose), view.camera, view.window,
    )[0]  # fmt: skip
    inner = cv2.erode(buffers.covered.astype(np.uint8), np.ones((3, 3))) > 0
    corners = x[body.speaker.faces[buffers.facet_id - 1]]
    expected = ((corners * buffers.barycentrics).sum(axis=2) + 80) / 160 * 255
    off = np.abs(picture[..., 0] - expected)[inner]
    assert np.median(off) < 1.5
    assert np.percentile(off, 90) < 6


def test_neighbours_in_facet_ids_have_colours_that_are_told_apart():
    speaker = load_speaker()
    chosen = palette.facet_palette(speaker.faces, speaker.weld)
    welded = np.zeros((speaker.weld.max() + 1, 3))
    welded[speaker.weld] = speaker.vertices
    mesh = trimesh.Trimesh(welded, speaker.weld[speaker.faces], process=False)
    left, right = mesh.face_adjacency.T
    assert len(left) > 15_000
    assert (chosen[left] != chosen[right]).all()
    lab = cv2.cvtColor(palette.FACET_COLOURS[None].astype(np.float32) / 255, cv2.COLOR_RGB2Lab)[0]
    apart = np.linalg.norm(lab[:, None] - lab, axis=2) + 1e3 * np.eye(len(lab))
    assert apart.min() > 20  # a difference of 2 in CIELAB is just seen


def test_facets_around_a_vertex_differ_even_where_an_edge_is_the_texture_seam():
    fan = np.array([[0, k, k % 6 + 1] for k in range(1, 7)])
    fan[3:, 0] = 7  # a copy of vertex 0
    chosen = palette.facet_palette(fan, np.array([0, 1, 2, 3, 4, 5, 6, 0]))
    assert len(set(chosen)) == 6


def test_ids_take_their_colours_and_0_is_background():
    colours = np.array([[1, 2, 3], [4, 5, 6]], np.uint8)
    picture = palette.paint_ids(np.array([[0, 1], [2, 1]]), colours)
    assert picture.tolist() == [[[255] * 3, [1, 2, 3]], [[4, 5, 6], [1, 2, 3]]]


def test_normals_have_the_usual_colours():
    to_camera, right, up = [0, 0, -1], [1, 0, 0], [0, -1, 0]
    picture = palette.paint_normals(
        np.array([[to_camera, right, up, up]], float), np.array([[True, True, True, False]])
    )
    assert picture[0].tolist() == [[128, 128, 255], [255, 128, 128], [128, 255, 128], [255] * 3]


def test_flow_has_a_hue_for_each_direction_and_fades_to_white():
    flow = np.array([[[2, 0], [-2, 0], [0, 0], [4, 0], [1, 0]]], float)
    picture = palette.paint_flow(flow, 2.0, np.array([[True, True, True, True, False]]))[0]
    red, cyan, still, longer, unknown = picture.tolist()
    assert red[0] > 200 > red[1] == red[2]
    assert cyan[0] < 100 < 200 < cyan[1] == cyan[2]
    assert still == unknown == [255] * 3
    assert longer == red


def test_values_beyond_the_scale_take_its_ends():
    scale = np.array([[0, 0, 0], [9, 9, 9]], np.uint8)
    picture = palette.paint_values(
        np.array([[-5.0, 99.0, 1]]), (0, 1), scale, np.array([[1, 1, 0]]) > 0
    )
    assert picture[0, :, 0].tolist() == [0, 9, 255]


def test_diagonals_of_quads_are_no_wires():
    corners = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [9, 9, 9]], float)
    drawn = quad_edges(corners, np.array([[0, 1, 2], [0, 2, 3]]), np.arange(5))
    # Edges by the corner opposite to them: the diagonal 0-2 is opposite to corner 1 and to 3.
    assert drawn.tolist() == [[True, False, True], [True, True, False]]


def test_wires_lie_within_half_their_width_of_the_edges():
    pixels = np.array([[10.0, 10], [50, 10], [10, 40]])
    y, x = np.mgrid[:50, :60].astype(float)
    b = (x - 10) / 40
    c = (y - 10) / 30
    weights = np.stack([1 - b - c, b, c], axis=2)
    inside = (weights >= 0).all(axis=2)
    faces, every = np.array([[0, 1, 2]]), np.ones((1, 3), bool)
    lines = line_cover(inside.astype(int), weights, pixels, faces, every, 5.0)
    slanted = np.abs(3 * (x - 10) + 4 * (y - 10) - 120) / 5  # from the edge 3 x + 4 y = 120
    near = np.minimum(np.minimum(x - 10, y - 10), slanted) < 2.5
    assert (lines == (inside & near)).all()
    lower = line_cover(inside.astype(int), weights, pixels, faces, every & [[0, 0, 1]], 5.0)
    assert (lower == (inside & (y - 10 < 2.5))).all()


def test_the_head_fills_the_picture_from_every_side():
    body = bodies()[0]
    for view in views_of(body.vertices, (100, 120), (0, 90, 200)):
        pixels = view.camera.project(view.pose.apply(body.vertices))
        assert (pixels > 0).all()
        assert (pixels < [99, 119]).all()
    nose, ear = body.speaker.landmarks["nose_tip"], int(body.vertices[:, 0].argmax())
    (turned,) = views_of(body.vertices, (100, 120), (90.0,))
    at = turned.camera.project(turned.pose.apply(body.vertices[[*nose, ear]]))
    depth = turned.pose.apply(body.vertices[[*nose, ear]])[:, 2]
    assert at[0, 0] > 80  # to its left is to the right of the picture
    assert depth[1] > depth[0]  # and its left ear is behind


def test_normals_of_a_drawn_head_face_the_camera():
    body = bodies()[0]
    view = View(
        Camera.ideal((48, 48)), Pose(FACING, np.array([0, 0, 700.0])), Camera.ideal((48, 48)).whole
    )
    frame = drawn_labels(CpuRenderer(), body, view)
    normals = frame.read("normals")[frame.ids > 0]
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1)
    assert (normals[:, 2] < 0.3).mean() > 0.98
