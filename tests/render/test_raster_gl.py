"""The OpenGL renderer on cases whose answer is known, by both vertex paths."""

from __future__ import annotations

import cv2
import moderngl
import numpy as np
import pytest
import shapes
from shapes import FISHY, STILL, draw_one, triangles
from snapping import half_step

from abs_engine.core.camera import Camera, Window
from abs_engine.core.errors import OpenGLError
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Candidates, ClassMaps, ColourError

pytestmark = pytest.mark.gl


def speck(camera: Camera, pixel, size: float, depth: float = 500.0):
    """Camera-frame corners of a small triangle whose projection surrounds a pixel position."""
    around = np.array([[-1, -1], [1, -1], [0, 1.3]]) * size + np.asarray(pixel)
    return np.concatenate([_undistort(camera, around), np.ones((3, 1))], axis=1) * depth


def _undistort(camera: Camera, pixels):
    """Invert `cv2.projectPoints` by fixed-point steps; a speck's corners must project exactly."""
    flat = np.asarray(pixels, np.float64)
    rays = np.zeros_like(flat)
    for _ in range(200):
        points = np.concatenate([rays, np.ones((len(rays), 1))], axis=1)
        seen = cv2.projectPoints(points, np.zeros(3), np.zeros(3), camera.matrix, camera.distortion)
        rays = rays + (flat - seen[0][:, 0]) / np.diag(camera.matrix)[:2]
    return rays


@pytest.mark.parametrize("distortion", [np.zeros(8), FISHY], ids=["ideal", "distorted"])
@pytest.mark.parametrize(
    "window",
    [Window(0, 0, 40, 30), Window(12, 7, 20, 16, 2.0), Window(3.5, 2.25, 32, 24, 0.5)],
    ids=["whole", "crop", "coarse"],
)
def test_pixel_centres_at_the_corners(renderer, distortion, window):
    """A triangle of a tenth of a pixel is seen where its centre projects to, and nowhere else."""
    camera = Camera(np.array([[55, 0, 19.2], [0, 57, 14.9], [0, 0, 1.0]]), (40, 30), distortion)
    width, height = window.drawn
    corners = [(0, 0), (width - 1, 0), (0, height - 1), (width - 1, height - 1)]
    for drawn in corners:
        pixel = window.to_image(np.array(drawn, np.float64))
        scene = triangles([speck(camera, pixel, 0.1 / window.scale)])
        projected = cv2.projectPoints(
            scene.mean.astype(np.float64), np.zeros(3), np.zeros(3), camera.matrix, distortion
        )[0][:, 0]
        assert np.abs(projected - pixel).max() < 0.2 / window.scale  # the oracle agrees
        seen = draw_one(renderer, scene, camera, window).facet_id
        assert np.argwhere(seen).tolist() == [[drawn[1], drawn[0]]]


@pytest.mark.parametrize("shift", [(0.3, 0), (-0.3, 0), (0, 0.3), (0, -0.3)])
def test_a_speck_beside_the_centre_is_not_seen(renderer, shift):
    camera = Camera.ideal((32, 24), 60.0)
    scene = triangles([speck(camera, np.add((10, 7), shift), 0.1)])
    assert not draw_one(renderer, scene, camera).covered.any()


def test_vertices_on_pixels_have_their_pixels(renderer):
    """Barycentrics and depth at a vertex, and the texture's corners, come out exactly."""
    camera = Camera.ideal((32, 24), 60.0)
    depth = np.array([400.0, 500.0, 700.0])
    pixels = np.array([[5, 4], [25, 6], [9, 20]], np.float64)
    rays = (pixels - camera.matrix[:2, 2]) / 60.0
    corner = np.concatenate([rays, np.ones((3, 1))], axis=1) * depth[:, None]
    middle = pixels.mean(axis=0)
    grown = corner + 1e-3 * (corner - corner.mean(axis=0))  # so that the vertices are inside
    colours = np.array([[[250, 10, 20], [30, 240, 50]], [[60, 70, 230], [1, 2, 3]]])
    seen = draw_one(renderer, triangles([grown], texture=colours), camera)
    for k, (x, y) in enumerate(pixels.astype(int)):
        assert seen.depth[y, x] == pytest.approx(depth[k], rel=2e-3)
        assert seen.barycentrics[y, x] == pytest.approx(np.eye(3)[k], abs=5e-3)
    assert seen.rgb[4, 5] == pytest.approx([250, 10, 20], abs=1)
    assert seen.rgb[6, 25] == pytest.approx([30, 240, 50], abs=1)
    assert seen.rgb[20, 9] == pytest.approx([60, 70, 230], abs=1)
    x, y = np.rint(middle).astype(int)
    ray = np.array([*((x, y) - camera.matrix[:2, 2]) / 60.0, 1.0])
    exact = np.linalg.solve(grown.T, ray)  # weights of the plane's point on the pixel's ray
    assert seen.barycentrics[y, x] == pytest.approx(exact / exact.sum(), abs=1e-3)
    assert seen.depth[y, x] == pytest.approx(1 / exact.sum(), rel=2e-4)


def test_rows_go_down(renderer):
    """y of the camera points down, and so do the rows; x to the right, and so do the columns."""
    camera = Camera.ideal((40, 40), 60.0)
    low = [[-20, 50, 400], [20, 50, 400], [0, 80, 400]]
    right = [[60, -10, 400], [90, -10, 400], [75, 15, 400]]
    seen = draw_one(renderer, triangles([low, right]), camera).facet_id
    rows, columns = np.nonzero(seen == 1)
    assert rows.min() > 20
    assert abs(columns.mean() - 19.5) < 1
    rows, columns = np.nonzero(seen == 2)
    assert columns.min() > 20
    assert abs(rows.mean() - 19.5) < 2


def test_the_texture_is_not_mirrored(renderer):
    """A face that looks into the camera: the subject's left is on the image's right, up is up."""
    scene = shapes.ball(2, 0)
    camera, window = shapes.view(64)
    seen = renderer.draw(scene, Candidates.one([], Pose.facing(600.0)), camera, window)[0]
    head = np.einsum("hwk,hwkc->hwc", seen.barycentrics, scene.mean[scene.faces[seen.facet_id - 1]])
    rows, columns = np.nonzero(seen.covered)
    points = head[rows, columns]
    assert np.corrcoef(points[:, 0], columns)[0, 1] > 0.99
    assert np.corrcoef(points[:, 1], rows)[0, 1] < -0.99
    assert (points[:, 2] > -1).all()  # the front half only


@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_the_nearer_facet_hides_the_farther(renderer, order):
    camera = Camera.ideal((32, 32), 60.0)
    near = [[-100, -100, 400], [100, -100, 400], [0, 150, 400]]
    far = [[-300, -300, 900], [300, -300, 900], [0, 450, 900]]
    scene = triangles([[near, far][k] for k in order], classes=[[1, 2][k] for k in order])
    seen = draw_one(renderer, scene, camera)
    assert seen.class_id[15, 15] == 1
    assert seen.depth[15, 15] == pytest.approx(400, rel=1e-5)
    assert (seen.class_id == 2).any()
    assert (seen.facet_id[15, 15] == 1) == (order == [0, 1])


def test_facets_that_cross_each_other_meet_at_the_right_pixel(renderer):
    camera = Camera.ideal((65, 65), 100.0)
    a = [[-200, -200, 400], [200, -200, 600], [0, 400, 500]]
    b = [[-200, -200, 600], [200, -200, 400], [0, 400, 500]]
    seen = draw_one(renderer, triangles([a, b]), camera)
    row = seen.class_id[32]
    assert set(row[:32]) == {0, 1}
    assert set(row[33:]) == {0, 2}
    assert (row > 0).sum() > 50


def test_back_faces_are_culled_if_the_scene_says_so(renderer):
    camera = Camera.ideal((32, 32), 60.0)
    front = [[-100, -100, 400], [0, 150, 400], [100, -100, 400]]  # counter-clockwise as one looks
    for corners, wound in ((front, True), (front[::-1], False)):
        for cull in (True, False):
            seen = draw_one(renderer, triangles([corners], cull=cull), camera)
            assert seen.covered.any() == (wound or not cull)
            term = ClassMaps(np.ones((2, 32, 32)))
            scene = triangles([corners], cull=cull)
            sums = renderer.measure(scene, STILL, camera, camera.whole, term)
            assert sums.pixels[0] == seen.covered.sum()


def test_what_is_behind_the_camera_is_cut_at_the_near_plane(gl, renderer):
    """A floor that runs from in front of the camera to behind it."""
    camera = Camera.ideal((33, 33), 40.0)
    floor = [[-4000, 100, 3000], [4000, 100, 3000], [0, 100, -3000]]
    behind = [[-50, -50, -400], [50, -50, -400], [0, 80, -400]]
    scene = triangles([floor, behind])
    seen = draw_one(renderer, scene, camera)
    assert not (seen.facet_id == 2).any()
    assert not seen.covered[:16].any()  # nothing above the horizon
    rows = np.arange(18, 33)
    assert seen.covered[rows, 16].all()
    # The row in which this depth lies: exact but for the driver's rounding of the corners.
    at = 16 + 100 * 40 / seen.depth[rows, 16]
    assert at == pytest.approx(rows, rel=1e-5, abs=half_step(gl))
    term = ClassMaps(np.ones((3, 33, 33)))
    sums = renderer.measure(scene, STILL, camera, camera.whole, term)
    assert sums.pixels[0] == seen.covered.sum()


def test_facets_without_area_draw_nothing(renderer):
    camera = Camera.ideal((32, 32), 60.0)
    point, good = [[0, 0, 400]] * 3, [[40, 40, 400], [90, 40, 400], [60, 90, 400]]
    line = [[-100, 0, 400], [0, 0, 400], [100, 0, 400]]
    scene = triangles([point, line, good])
    seen = draw_one(renderer, scene, camera)
    assert set(np.unique(seen.facet_id)) == {0, 3}
    assert np.isfinite(seen.depth).all()
    sums = renderer.measure(scene, STILL, camera, camera.whole, ColourError(np.zeros((32, 32, 3))))
    assert np.isfinite(sums.total).all()


def test_ids_above_2_to_the_24_would_survive(renderer):
    """Class ids are integers all the way: no float would hold this one."""
    camera = Camera.ideal((16, 16), 60.0)
    big = 2**24 + 1
    scene = triangles([[[-400, -400, 400], [400, -400, 400], [0, 700, 400]]], classes=[big])
    assert draw_one(renderer, scene, camera).class_id[8, 8] == big


def test_the_background_is_zero(renderer):
    camera, window = shapes.view(48)
    scene = shapes.ball(1, 2)
    seen = renderer.draw(scene, shapes.states(scene, 1), camera, window)[0]
    out = ~seen.covered
    assert out.any()
    for part in (seen.rgb, seen.class_id, seen.depth, seen.barycentrics):
        assert not part[out].any()
    assert np.abs(seen.barycentrics[seen.covered].sum(axis=1) - 1).max() < 1e-6


def test_buffers_have_the_promised_types(renderer):
    camera = Camera.ideal((20, 12), 30.0)
    seen = draw_one(renderer, triangles([[[-9, -9, 40], [9, -9, 40], [0, 9, 40]]]), camera)
    kinds = [(p.shape, p.dtype.name) for p in vars(seen).values()]
    assert kinds == [
        ((12, 20, 3), "float32"),
        ((12, 20), "int32"),
        ((12, 20), "int32"),
        ((12, 20), "float32"),
        ((12, 20, 3), "float32"),
    ]


def test_an_error_of_opengl_is_not_taken_for_an_empty_picture(renderer, monkeypatch):
    camera, scene = (
        Camera.ideal((20, 12), 30.0),
        triangles([[[-9, -9, 40], [9, -9, 40], [0, 9, 40]]]),
    )
    draw = renderer._path.draw

    def broken(*given):
        renderer.gl.ctx.enable_direct(0xFFFF)  # refused by OpenGL, which goes on
        return draw(*given)

    def full(*_):
        renderer.gl.ctx.enable_direct(0xFFFF)
        raise moderngl.Error("out of\nmemory")

    for failing, said in ((broken, "GL_INVALID_ENUM"), (full, "out of memory")):
        monkeypatch.setattr(renderer._path, "draw", failing)
        with pytest.raises(OpenGLError, match=f"OpenGL failed .{said}") as caught:
            draw_one(renderer, scene, camera)
        assert "--renderer cpu" in caught.value.remedy
    monkeypatch.setattr(renderer._path, "draw", draw)
    assert draw_one(renderer, scene, camera).covered.any()
