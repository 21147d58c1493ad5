"""The CPU rasteriser by itself: coverage, depth order, what is cut off, and the fused sums."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import shapes
from shapes import FISHY, STILL, draw_one, triangles

from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Candidates, ClassMaps, ColourError, Scene
from abs_engine.render.cpu import CpuRenderer
from abs_engine.render.pixelsum import texel_cells

DEEP = 500.0


@pytest.fixture
def cpu():
    with CpuRenderer() as renderer:
        yield renderer


def flat_camera(width: int, height: int, **depth_range: float) -> Camera:
    """Pixel = x, y of the head frame at depth `DEEP`."""
    matrix = np.array([[DEEP, 0, 0], [0, DEEP, 0], [0, 0, 1.0]])
    return Camera(matrix, (width, height), **depth_range)


def grid(width: int, height: int, jitter: float, seed: int):
    """A triangulated rectangle seen face-on, corners (F, 3, 3), its inner points moved about."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.linspace(4, 44, width), np.linspace(3, 33, height))
    x[1:-1, 1:-1] += rng.uniform(-jitter, jitter, (height - 2, width - 2))
    y[1:-1, 1:-1] += rng.uniform(-jitter, jitter, (height - 2, width - 2))
    points = np.stack([x, y, np.full_like(x, DEEP)], axis=-1)
    a, b = points[:-1, :-1], points[:-1, 1:]
    c, d = points[1:, 1:], points[1:, :-1]
    both = np.stack([np.stack([a, b, c], axis=-2), np.stack([a, c, d], axis=-2)])
    return both.reshape(-1, 3, 3)


def square(z: float, low: float = 2.0, high: float = 12.0):
    """Two triangles over pixels `low` to `high`, at depth z."""
    corners = np.array([[low, low], [high, low], [high, high], [low, high]]) * z / DEEP
    points = np.column_stack([corners, np.full(4, z)])
    return points[[[0, 1, 2], [0, 2, 3]]]


@pytest.mark.parametrize("jitter", [0.0, 1.3])
@pytest.mark.parametrize("columns", [5, 17, 83])
def test_a_mesh_is_watertight_and_no_pixel_is_drawn_twice(cpu, columns, jitter):
    corners = grid(columns, columns - 2, jitter * 40 / columns / 4, seed=columns)
    camera = flat_camera(49, 37)
    counts = np.zeros((37, 49), int)
    for facet in corners:  # each by itself: nothing can hide that two claim one pixel
        counts += draw_one(cpu, triangles([facet]), camera).covered
    expected = np.zeros_like(counts)
    expected[3:33, 4:44] = 1  # top and left edges own their pixels, bottom and right do not
    assert np.array_equal(counts, expected)


def test_nothing_is_drawn_behind_the_camera_or_of_no_area(cpu):
    camera = flat_camera(16, 16)
    behind = square(-DEEP)
    line = [[[2, 2, DEEP], [12, 12, DEEP], [7, 7, DEEP]]]
    point = [[[5, 5, DEEP]] * 3]
    scene = triangles(np.concatenate([behind, line, point, square(DEEP)[:1]]))
    seen = draw_one(cpu, scene, camera)
    assert set(np.unique(seen.facet_id)) == {0, 5}


def test_a_facet_is_cut_at_the_near_plane(cpu):
    camera = flat_camera(32, 32, near=100.0)
    floor = [[[-40, 20, 700], [90, 20, 700], [10, 4, -300]]]
    seen = draw_one(cpu, triangles(floor), camera)
    assert seen.covered.any()
    assert seen.depth[seen.covered].min() >= 100.0 - 1e-3


def test_what_is_beyond_far_is_not_drawn(cpu):
    camera = flat_camera(32, 32, far=800.0)
    assert draw_one(cpu, triangles(square(799.0)), camera).covered.sum() == 100
    assert not draw_one(cpu, triangles(square(801.0)), camera).covered.any()
    wall = np.array([[[0, -900, 400.0], [0, 900, 400], [60, 0, 1400]]])
    whole = draw_one(cpu, triangles(wall), flat_camera(32, 32))
    cut = draw_one(cpu, triangles(wall), camera)
    assert whole.depth.max() > 850
    clear = np.abs(whole.depth - 800) > 0.5  # mm; vertices are snapped to 1/256 pixel
    assert np.array_equal(cut.covered[clear], (whole.covered & (whole.depth < 800))[clear])


def test_the_nearer_facet_wins_and_the_first_of_equals(cpu):
    camera = flat_camera(16, 16)
    near_last = np.concatenate([square(DEEP), square(DEEP - 0.01), square(DEEP)])
    assert set(np.unique(draw_one(cpu, triangles(near_last), camera).facet_id)) == {0, 3, 4}
    equal = np.concatenate([square(DEEP), square(DEEP)])
    assert set(np.unique(draw_one(cpu, triangles(equal), camera).facet_id)) == {0, 1, 2}


def test_facets_seen_from_behind_are_culled(cpu):
    camera = flat_camera(16, 16)
    inside_out = square(DEEP)  # clockwise to the camera, whose y is down: seen from behind
    front = inside_out[:, ::-1]
    assert not draw_one(cpu, triangles(inside_out, cull=True), camera).covered.any()
    assert draw_one(cpu, triangles(front, cull=True), camera).covered.sum() == 100


def terms(seen, seed=3):
    rng = np.random.default_rng(seed)
    noisy = np.clip(seen.rgb + rng.normal(0, 12, seen.rgb.shape), 0, 255)
    return ClassMaps(rng.uniform(0, 4, (5, *seen.depth.shape))), ColourError(noisy)


def value(seen, term) -> float:
    """The term of read-back buffers, in plain NumPy."""
    if isinstance(term, ClassMaps):
        rows, columns = np.nonzero(seen.covered)
        return float(term.maps.astype(float)[seen.class_id[rows, columns], rows, columns].sum())
    frame, rgb = term.frame.astype(float) + 1, seen.rgb.astype(float) + 1
    difference = frame / frame.sum(2, keepdims=True) - rgb / rgb.sum(2, keepdims=True)
    return float((difference**2).sum(2)[seen.covered].sum())


def test_a_barrel_lens_draws_nothing_that_lies_outside_of_the_view(cpu):
    lens = np.array([-0.32, 0.12, 0, 0, -0.02])  # turns back just outside of the picture
    ideal = Camera.ideal((64, 48), 32 / np.tan(np.radians(39)))
    camera = Camera(ideal.matrix, ideal.size, lens)
    below = np.array([[[-0.5, 2.2, 1], [0.5, 2.2, 1], [0, 2.4, 1]]]) * DEEP
    assert not draw_one(cpu, triangles(below), camera).covered.any()
    assert draw_one(cpu, triangles(below / [1, 4, 1]), camera).covered.any()


@pytest.mark.parametrize("distortion", [np.zeros(8), FISHY], ids=["ideal", "distorted"])
@pytest.mark.parametrize("pixels", [24, 64, 131])
def test_the_fused_value_is_that_of_the_buffers(cpu, pixels, distortion):
    scene = shapes.ball(shapes.SMALL)
    ideal, window = shapes.view(pixels)
    camera = Camera(ideal.matrix, ideal.size, distortion)
    many = shapes.states(scene, 6)
    drawn = cpu.draw(scene, many, camera, window)
    for term in terms(drawn[0]):
        sums = cpu.measure(scene, many, camera, window, term)
        assert sums.total == pytest.approx([value(seen, term) for seen in drawn], rel=1e-5)
        assert sums.pixels.tolist() == [int(seen.covered.sum()) for seen in drawn]


def test_the_fused_value_holds_where_facets_are_cut(cpu):
    rng = np.random.default_rng(4)
    corners = rng.uniform([-250, -250, -200], [250, 250, 900], (300, 1, 3))
    corners = corners + rng.normal(0, 200, (300, 3, 3))
    texture = shapes.noise_texture(12, 9)
    scene = triangles(corners, classes=1 + np.arange(300) % 4, texture=texture)
    camera = Camera.ideal((61, 47), 60.0)
    seen = draw_one(cpu, scene, camera)
    assert seen.covered.mean() > 0.5
    for term in terms(seen):
        sums = cpu.measure(scene, STILL, camera, camera.whole, term)
        assert sums.total[0] == pytest.approx(value(seen, term), rel=1e-5)


@pytest.mark.parametrize("shape", [(1, 1, 3), (1, 5, 3), (4, 1, 3), (3, 2, 3)])
def test_small_textures_and_coordinates_outside(cpu, shape):
    rng = np.random.default_rng(5)
    scene = shapes.ball(1, 0)
    wide = Scene(
        **{
            **vars(scene),
            "uv": scene.uv * 3 - 1,  # clamped to the edge
            "texture": rng.integers(0, 256, shape),
        }
    )
    camera, window = shapes.view(40)
    state = Candidates.one(np.zeros(0), Pose.facing(shapes.DISTANCE))
    seen = cpu.draw(wide, state, camera, window)[0]
    term = terms(seen)[1]
    sums = cpu.measure(wide, state, camera, window, term)
    assert sums.total[0] == pytest.approx(value(seen, term), rel=1e-5)


def test_texel_cells_hold_the_four_neighbours():
    texture = np.arange(2 * 3 * 3, dtype=np.uint8).reshape(2, 3, 3) + 200
    corners = texel_cells(texture).view(np.uint8).reshape(3, 2, 3, 4)
    assert corners[1, 0, 0].tolist() == [*texture[0, :2, 1], *texture[1, :2, 1]]
    assert corners[2, 1, 2].tolist() == [texture[1, 2, 2]] * 4


def test_a_batch_equals_single_calls_bit_for_bit(cpu):
    scene = shapes.ball(shapes.SMALL)
    camera, window = shapes.view(64)
    many = shapes.states(scene, 5)
    for term in terms(cpu.draw(scene, many, camera, window)[0]):
        sums = cpu.measure(scene, many, camera, window, term)
        for i in range(len(many)):
            one = Candidates(*(part[i : i + 1] for part in vars(many).values()))
            alone = cpu.measure(scene, one, camera, window, term)
            assert (alone.total[0], alone.pixels[0]) == (sums.total[i], sums.pixels[i])


def test_threads_share_a_renderer(cpu):
    scene = shapes.ball(shapes.SMALL)
    camera, window = shapes.view(64)
    many = shapes.states(scene, 40)
    for term in terms(cpu.draw(scene, many, camera, window)[0]):
        alone = cpu.measure(scene, many, camera, window, term)
        with ThreadPoolExecutor(4) as pool:
            jobs = [pool.submit(cpu.measure, scene, many, camera, window, term) for _ in range(8)]
            for job in jobs:
                assert np.array_equal(job.result().total, alone.total)


def test_windows_and_scenes_may_alternate(cpu):
    camera, small = shapes.view(32)
    _, large = shapes.view(64)
    wide = shapes.view(64)[0]
    for scene in (shapes.ball(0, 1), shapes.ball(2, 1), shapes.ball(0, 1)):
        state = shapes.states(scene, 1)
        for cam, window in ((camera, small), (wide, large), (camera, small)):
            seen = cpu.draw(scene, state, cam, window)[0]
            sums = cpu.measure(scene, state, cam, window, terms(seen)[1])
            assert sums.pixels[0] == seen.covered.sum() > 0


@pytest.mark.parametrize("term", [ClassMaps(np.ones((5, 16, 32))), ColourError(np.ones((9, 9, 3)))])
def test_a_term_of_another_size_is_refused(cpu, term):
    scene = shapes.ball(0, 1)
    camera, window = shapes.view(32)
    with pytest.raises(ParameterError, match="the window 32x32"):
        cpu.measure(scene, shapes.states(scene, 1), camera, window, term)


def test_a_wrong_number_of_weights_is_refused(cpu):
    camera, window = shapes.view(32)
    with pytest.raises(ParameterError, match="weights"):
        cpu.draw(shapes.ball(0, 2), shapes.states(shapes.ball(0, 3), 1), camera, window)


def test_a_class_without_a_map_is_refused(cpu):
    scene = shapes.ball(0, 1)
    camera, window = shapes.view(32)
    with pytest.raises(ParameterError, match="one map for each class"):
        cpu.measure(scene, shapes.states(scene, 1), camera, window, ClassMaps(np.ones((2, 32, 32))))


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_weights_that_are_no_numbers_draw_nothing(cpu, bad):
    scene = shapes.ball(1, 2)
    camera, window = shapes.view(32)
    state = Candidates.one([bad, 0.0], Pose.facing(shapes.DISTANCE))
    assert not cpu.draw(scene, state, camera, window)[0].covered.any()
    for term in (ClassMaps(np.ones((5, 32, 32))), ColourError(np.ones((32, 32, 3)))):
        sums = cpu.measure(scene, state, camera, window, term)
        assert (sums.total[0], sums.pixels[0]) == (0.0, 0)
