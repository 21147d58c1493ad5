"""Points of a shell between its nodes."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.core.errors import ParameterError
from abs_engine.face.shape.dots import ShellPoints, nearest_points

NODES = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [4, 4, 2.0]])
FACES = np.array([[0, 1, 2], [1, 3, 2]])
POINTS = ShellPoints(np.array([[0, 1, 2], [1, 3, 2]]), np.array([[0.5, 0.25, 0.25], [0, 1, 0.0]]))


def test_a_point_is_the_weighted_mean_of_its_corners():
    np.testing.assert_allclose(POINTS.at(NODES), [[1, 1, 0], [4, 4, 2]])
    np.testing.assert_allclose(POINTS.at(np.stack([NODES, 2 * NODES]))[1, 0], [2, 2, 0])
    assert len(POINTS) == 2
    np.testing.assert_allclose(POINTS.subset(slice(1, 2)).at(NODES), [[4, 4, 2]])


@pytest.mark.parametrize("coordinates", ["xyz", "yz", "xy", "z"])
def test_rows_give_the_coordinates_asked_for(coordinates):
    rows = POINTS.rows(len(NODES), coordinates)
    columns = ["xyz".index(c) for c in coordinates]
    np.testing.assert_allclose(rows @ NODES.ravel(), POINTS.at(NODES)[:, columns].ravel())


def test_rows_along_any_directions():
    basis = np.array([[0.6, 0.8, 0], [0, 0, 1.0]])
    rows = POINTS.projected(len(NODES), basis)
    np.testing.assert_allclose(rows @ NODES.ravel(), (POINTS.at(NODES) @ basis.T).ravel())


@pytest.mark.parametrize("wrong", ["", "w", "xx"])
def test_no_coordinates_are_refused(wrong):
    with pytest.raises(ParameterError, match="not coordinates"):
        POINTS.rows(4, wrong)


def test_the_nearest_points_of_points_off_the_shell():
    found = nearest_points(NODES, FACES, np.array([[1, 1, 0.7], [-3, 1, 0], [4, 4, 9.0]]))
    np.testing.assert_allclose(found.at(NODES), [[1, 1, 0], [0, 1, 0], [4, 4, 2]], atol=1e-9)
    assert found.corners[0].tolist() == [0, 1, 2]
    np.testing.assert_allclose(found.weights.sum(axis=1), 1)
