"""Facet scores and forces: their sums, the work they do, and the score's numerical derivative."""

from __future__ import annotations

import numpy as np
import pytest
import shapes

from abs_engine.compare.facets import FacetLikelihood
from abs_engine.compare.forces import (
    border_forces,
    facet_forces,
    facet_scores,
    lifted,
    node_forces,
    slopes,
)
from abs_engine.compare.sums import buffer_sums
from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import ClassMaps, Scene
from abs_engine.render.cpu import CpuRenderer

CPU = CpuRenderer()
PIXELS = 160
CAMERA = Camera.ideal((PIXELS, PIXELS), 400.0)
ROWS, COLUMNS = np.mgrid[:PIXELS, :PIXELS] / PIXELS


def waves(count: int, frequency: float = 1.0) -> np.ndarray:
    """Maps (C, H, W) from 0 to 1 that change slowly, each otherwise."""
    phase = np.arange(count)[:, None, None]
    along = COLUMNS * (2 + phase) + ROWS * (3 - phase)
    return np.float32(0.5 + 0.4 * np.sin(frequency * along + 1.7 * phase))


def ball() -> tuple[Scene, object]:
    scene = shapes.ball(shapes.LARGE, n_modes=1)
    one = shapes.states(scene, 1)
    return scene, CPU.draw(scene, one, CAMERA, CAMERA.whole)[0]


@pytest.mark.parametrize("kind", ["slow", "noise"])
def test_exact_scores_add_up_to_the_score_of_all(kind):
    scene, seen = ball()
    noise = np.random.default_rng(0).uniform(0, 1, (5, PIXELS, PIXELS)).astype(np.float32)
    maps = waves(5) if kind == "slow" else noise
    scores = facet_scores(seen, maps, scene.facet_class, "exact")
    assert scores.sum() == pytest.approx(buffer_sums([seen], ClassMaps(maps)).total[0], rel=1e-9)
    hidden = np.bincount(seen.facet_id.ravel(), minlength=len(scores) + 1)[1:] == 0
    assert 0.4 < hidden.mean() < 0.8
    assert not scores[hidden].any()


def test_a_score_by_hand():
    """A facet gets its own class's map over its own pixels, even where another hides part."""
    near = np.array([[-20, -20, 400], [20, -20, 400], [-20, 20, 400]], float)
    scene = shapes.triangles([near, 2.5 * near * [1, 1, 0.5]], classes=[2, 1])
    seen = shapes.draw_one(CPU, scene, CAMERA)
    maps = np.stack([np.full_like(COLUMNS, 9.0), COLUMNS, ROWS])
    first, second = (seen.facet_id == k for k in (1, 2))
    assert min(first.sum(), second.sum()) > 500
    scores = facet_scores(seen, maps, scene.facet_class, "exact")
    np.testing.assert_allclose(scores, [ROWS[first].sum(), COLUMNS[second].sum()])


def test_one_sample_is_exact_for_even_maps_and_near_for_small_facets():
    scene, seen = ball()
    even = np.ones((5, PIXELS, PIXELS)) * np.arange(5)[:, None, None]
    exact, sample = (facet_scores(seen, even, scene.facet_class, r) for r in ("exact", "sample"))
    np.testing.assert_allclose(sample, exact, rtol=1e-6)
    exact, sample = (
        facet_scores(seen, waves(5, 3.0), scene.facet_class, r) for r in ("exact", "sample")
    )
    assert np.abs(sample - exact).max() < 0.02 * exact.max()
    assert np.abs(sample - exact).max() > 0  # it is another rule
    assert sample.sum() == pytest.approx(exact.sum(), rel=1e-3)


def test_a_half_hidden_facet_is_sampled_where_it_is_seen():
    """Its whole centre lies behind the facet in front, where the map is 0."""
    front = [[[-45, -60, 300], [10, -60, 300], [10, 60, 300]],
             [[-45, -60, 300], [10, 60, 300], [-45, 60, 300]]]  # fmt: skip
    behind = [[[-40, -40, 400], [40, -40, 400], [40, 40, 400]]]
    scene = shapes.triangles(front + behind, classes=[1, 1, 2])
    seen = shapes.draw_one(CPU, scene, CAMERA)
    shown = seen.facet_id == 3
    maps = np.stack([0 * ROWS, 0 * ROWS, (np.arange(PIXELS) > 93)[None] * np.ones((PIXELS, 1))])
    sample = facet_scores(seen, maps, scene.facet_class, "sample")
    assert shown.sum() > 100
    assert sample[2] == pytest.approx(shown.sum())


def test_slopes_point_right_and_down():
    right, down = slopes(np.stack([3 * ROWS * PIXELS - 2 * COLUMNS * PIXELS]))[0]
    np.testing.assert_allclose(right, -2)
    np.testing.assert_allclose(down, 3)


@pytest.mark.parametrize("rule", ["exact", "sample"])
def test_facet_forces_are_the_slope_times_the_area(rule):
    scene, seen = ball()
    maps = np.stack([(k + 1) * COLUMNS - 2 * ROWS for k in range(5)]) * PIXELS
    forces = facet_forces(seen, slopes(maps), scene.facet_class, rule)
    area = np.bincount(seen.facet_id.ravel(), minlength=len(scene.faces) + 1)[1:]
    np.testing.assert_allclose(forces[:, 0], area * (scene.facet_class + 1), rtol=1e-5)
    np.testing.assert_allclose(forces[:, 1], -2 * area, rtol=1e-5)


def test_an_unknown_rule_is_named():
    scene, seen = ball()
    with pytest.raises(ParameterError, match="rule 'some'") as caught:
        facet_scores(seen, waves(5), scene.facet_class, "some")
    assert "exact or sample" in caught.value.remedy


def test_a_facets_force_goes_to_its_nodes_in_equal_parts():
    forces = np.array([[3.0, -6.0], [0.3, 0.0]])
    faces = np.array([[0, 1, 2], [2, 1, 4]])
    found = node_forces(forces, faces, 5)
    expected = [[1, -2], [1.1, -2], [1.1, -2], [0, 0], [0.1, 0]]
    np.testing.assert_allclose(found, expected, atol=1e-12)
    many = np.random.default_rng(0).normal(size=(1280, 3))
    ball_faces = shapes.ball().faces
    found = node_forces(many, ball_faces, int(ball_faces.max()) + 1)
    np.testing.assert_allclose(found.sum(axis=0), many.sum(axis=0))


def test_lifted_forces_do_the_same_work_in_space_as_in_the_picture():
    rng = np.random.default_rng(1)
    matrix = np.array([[500.0, 0, 90], [0, 450.0, 70], [0, 0, 1]])
    camera = Camera(matrix, (PIXELS, PIXELS))
    points = rng.uniform([-80, -80, 300], [80, 80, 700], (200, 3))
    flat, moved = rng.normal(size=(200, 2)), rng.normal(size=(200, 3)) * 1e-4
    scale = 1.7
    seen = scale * (camera.project(points + moved) - camera.project(points - moved)) / 2
    work = (lifted(flat, points, camera, scale) * moved).sum(axis=1)
    np.testing.assert_allclose(work, (flat * seen).sum(axis=1), atol=1e-9, rtol=1e-4)
    assert np.abs(work).max() > 1e-5


# ---- borders -------------------------------------------------------------------------------------


def grid(width: float, height: float, at: np.ndarray, angle: float) -> np.ndarray:
    """Nodes (9, 3) of a turned patch, row by row."""
    y, x = np.meshgrid([-0.5, 0, 0.5], [-0.5, 0, 0.5], indexing="ij")
    flat = np.stack([x.ravel() * width, y.ravel() * height], axis=1)
    c, s = np.cos(angle), np.sin(angle)
    return np.column_stack([flat @ np.array([[c, s], [-s, c]]), np.zeros(9)]) + at


def patches() -> Scene:
    """A patch of class 1 before a larger one whose left is class 2 and whose right is class 3."""
    front = grid(60, 50, np.array([12.0, 5, 380]), 0.37)
    rear = grid(105, 100, np.array([-8.0, -3, 430]), 0.21)
    corner = np.array([0, 1, 3, 4])[:, None]
    quads = np.hstack([corner, corner + 1, corner + 4, corner + 3])
    faces = np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    halves = np.tile([2, 3, 2, 3], 2)
    return Scene(
        np.vstack([front, rear]), np.zeros((0, 18, 3)), np.vstack([faces, faces + 9]),
        np.zeros((18, 2)), np.r_[np.ones(8), halves], np.zeros((1, 1, 3)), cull=False,
    )  # fmt: skip


def likelihood(scene: Scene, maps: np.ndarray) -> FacetLikelihood:
    terms = ClassMaps(np.concatenate([maps[:1] * 0, maps[1:]]))
    return FacetLikelihood(
        CPU, scene, CAMERA, CAMERA.whole, terms, PIXELS * PIXELS, 250.0, np.float32(maps[0])
    )


def summed(scene: Scene, maps: np.ndarray) -> float:
    """The score, of what is drawn and of what is left free, from the likelihood."""
    value = likelihood(scene, maps).negative_log(shapes.STILL)[0]
    return PIXELS * PIXELS * float(np.exp(-value / 250.0))


def test_border_forces_are_the_derivative_of_the_score():
    """Of every node in either direction, shifted by up to two pixels; one object hides another."""
    scene, maps = patches(), waves(4)
    seen = shapes.draw_one(CPU, scene, CAMERA)
    assert all((seen.class_id == k).sum() > 500 for k in range(4))
    forces = border_forces(seen, maps, scene.faces, 18)
    numerical = np.zeros((18, 2))
    pixel = scene.mean[:, 2] / CAMERA.matrix[0, 0]
    shifts = np.array([0.7, 1.1, 1.6, 2.0])
    for node in range(18):
        for axis in (0, 1):
            change = []
            for shift in np.r_[shifts, -shifts]:
                mean = scene.mean.copy()
                mean[node, axis] += shift * pixel[node]
                moved = Scene(**{**vars(scene), "mean": mean})
                change.append(summed(moved, maps) / shift)
            numerical[node, axis] = np.mean(change)
    apart = np.linalg.norm(forces - numerical, axis=1)
    size = np.linalg.norm(numerical, axis=1)
    assert size.max() > 10
    assert np.linalg.norm(apart) < 0.1 * np.linalg.norm(size)
    assert apart.max() < 0.12 * size.max()


def test_borders_within_a_class_push_nothing():
    """A ball of one class: only its outline is pushed."""
    scene, _ = ball()
    one = Scene(**{**vars(scene), "facet_class": np.ones(len(scene.faces))})
    seen = CPU.draw(one, shapes.states(one, 1), CAMERA, CAMERA.whole)[0]
    maps = waves(2)
    forces = border_forces(seen, maps, one.faces, len(one.mean))
    rows, columns = np.nonzero(seen.covered)
    middle = np.hypot(rows - rows.mean(), columns - columns.mean()) < 0.8 * np.ptp(rows) / 2
    inner = np.unique(one.faces[seen.facet_id[rows[middle], columns[middle]] - 1])
    assert len(inner) > 300
    assert not forces[inner].any()
    assert np.abs(forces).max() > 0.1
    assert not border_forces(seen, np.stack([maps[0], maps[0]]), one.faces, len(one.mean)).any()


def test_the_surface_in_front_is_pushed_and_not_the_one_behind():
    """The front gains where it covers the rear; the rear's nodes are far from any border."""
    front = [[[-20, -20, 300], [20, -20, 300], [20, 20, 300]]]
    rear = [[[-900, -900, 400], [900, -900, 400], [0, 1200, 400]]]
    scene = shapes.triangles(front + rear, classes=[1, 2], cull=False)
    seen = shapes.draw_one(CPU, scene, CAMERA)
    assert seen.covered.all()
    maps = np.stack([0 * ROWS, 0 * ROWS + 1, 0 * ROWS])
    forces = border_forces(seen, maps, scene.faces, 6)
    assert not forces[3:].any()
    # every point of the outline is pushed outwards by 1 per pixel: the forces cancel, and each
    # node's work of growing about the centre is positive
    np.testing.assert_allclose(forces.sum(axis=0), 0, atol=1e-5)
    centre = scene.mean[:3, :2].mean(axis=0)
    assert ((scene.mean[:3, :2] - centre) * forces[:3]).sum(axis=1).min() > 1
