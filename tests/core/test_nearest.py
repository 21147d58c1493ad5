"""The nearest places on facets, and the edges of a mesh, against what is slower but plain."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from trimesh.triangles import closest_point

from abs_engine.core.geometry import edges_of
from abs_engine.core.nearest import nearest_on_facets

BALL = trimesh.creation.icosphere(2)
LONG = BALL.vertices * [40.0, 1.0, 1.0]  # slivers that reach far from their centres


@pytest.mark.parametrize("vertices", [BALL.vertices, LONG])
@pytest.mark.parametrize("far", [0.5, 1.0, 60.0])
def test_no_facet_is_nearer(vertices, far):
    points = far * np.random.default_rng(3).normal(size=(40, 3))
    facet, place = nearest_on_facets(vertices[BALL.faces], points)
    every = np.stack([
        closest_point(vertices[BALL.faces], np.tile(point, (len(BALL.faces), 1)))
        for point in points
    ])  # fmt: skip
    away = np.linalg.norm(every - points[:, None], axis=2)
    np.testing.assert_allclose(np.linalg.norm(place - points, axis=1), away.min(axis=1))
    np.testing.assert_allclose(place, every[np.arange(len(points)), facet], atol=1e-12)


def test_of_facets_that_are_as_near_it_is_the_first():
    one = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    facet, place = nearest_on_facets(np.stack([one + 5, one, one]), np.array([[0.2, 0.2, 1.0]]))
    assert facet.tolist() == [1]
    np.testing.assert_allclose(place, [[0.2, 0.2, 0.0]])


def test_edges_are_there_once_with_the_number_of_their_facets():
    edges, count = edges_of(BALL.faces)
    np.testing.assert_array_equal(edges, np.unique(BALL.edges_sorted, axis=0))
    assert set(count.tolist()) == {2}
    edges, count = edges_of(np.array([[3, 1, 0], [1, 3, 7]], np.int32))
    assert edges.tolist() == [[0, 1], [0, 3], [1, 3], [1, 7], [3, 7]]
    assert count.tolist() == [1, 1, 2, 1, 1]
