"""The shell of the lips, cut from the bundled head."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.face.shape.lip_shell import COLUMNS, cut_lip_shell
from abs_engine.face.shape.minimum_norm_deformation import reach
from abs_engine.io.assets import load_speaker

SPEAKER = load_speaker()
SHELL = cut_lip_shell(SPEAKER)
REST = SHELL.nodes(SPEAKER.vertices)


def unit(name: str) -> np.ndarray:
    """Displacements (V, 3) of a face unit at weight 1."""
    return SPEAKER.units[SPEAKER.unit_names.index(name)].astype(np.float64)


def test_it_has_the_papers_size():
    assert len(SHELL) == 204
    assert SHELL.elastic_at(SHELL.nodes(SPEAKER.vertices)).stiffness.shape == (612, 612)


def test_it_is_one_ring_around_the_mouth():
    edges = np.sort(SHELL.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    kinds, count = np.unique(edges, axis=0, return_counts=True)
    assert len(SHELL) - len(kinds) + len(SHELL.faces) == 0  # Euler characteristic of an annulus
    assert set(count) == {1, 2}
    assert (count == 1).sum() == 2 * COLUMNS


def test_nodes_lie_in_their_facets():
    np.testing.assert_allclose(SHELL.weights.sum(axis=1), 1)
    assert SHELL.weights.min() > -1e-6
    assert np.abs(REST[SHELL.border, :2] - REST[:, :2].mean(axis=0)).max() < 40


def test_it_faces_the_front_and_no_triangle_is_a_sliver():
    elastic = SHELL.elastic_at(SHELL.nodes(SPEAKER.vertices))
    assert (elastic.frames[:, 2, 2] > 0).mean() > 0.95
    assert elastic.areas.min() > 0.2
    assert elastic.areas.max() < 40


def test_each_column_keeps_to_its_own_lip():
    """Else a node of the lower lip stays behind with the upper one when the jaw goes down."""
    lip = {
        name: np.unique(SPEAKER.faces[SPEAKER.facet_class == SPEAKER.class_id(name)])
        for name in ("upper_lip", "lower_lip")
    }
    half, on_lips = COLUMNS // 2, SHELL.corners[: 3 * COLUMNS].reshape(3, COLUMNS, 3)
    assert np.isin(on_lips[:, 1:half], lip["upper_lip"]).all()
    assert np.isin(on_lips[:, half + 1 :], lip["lower_lip"]).all()
    down = np.einsum("nkd,nk->nd", unit("jawOpen")[SHELL.corners], SHELL.weights)[:, 1]
    down = down[: 3 * COLUMNS].reshape(3, COLUMNS)
    assert np.abs(np.diff(down, axis=0)).max() < 4.0


def test_lip_facets_lie_between_the_contours():
    lips = REST[SHELL.faces[SHELL.lip]].mean(axis=1)
    outer = SPEAKER.vertices[SPEAKER.landmarks["outer_lip"]]
    assert SHELL.lip.sum() == 4 * COLUMNS
    assert lips[:, 1].min() > outer[:, 1].min() - 0.5
    assert lips[:, 1].max() < outer[:, 1].max() + 0.5


@pytest.mark.parametrize("name", ["jawOpen", "mouthPucker", "mouthSmileLeft"])
def test_it_moves_with_the_head(name):
    moved = SHELL.nodes(SPEAKER.vertices + unit(name)) - REST
    expected = np.einsum("nkd,nk->nd", unit(name)[SHELL.corners], SHELL.weights)
    np.testing.assert_allclose(moved, expected, atol=1e-4)
    assert np.linalg.norm(moved[: 3 * COLUMNS], axis=1).max() > 4


@pytest.mark.parametrize("name", ["mouthPucker", "mouthUpperUpLeft", "mouthSmileLeft"])
def test_sixteen_points_say_much_of_a_posture(name):
    """Eq. 2: from 16 of the lips' nodes the other lip nodes follow, better than at rest."""
    true = SHELL.nodes(SPEAKER.vertices + unit(name)) - REST
    outer = 2 * COLUMNS + np.arange(0, COLUMNS, 4)
    inner = np.arange(2, COLUMNS, 5)
    seen = np.concatenate([outer, inner])
    dofs = (3 * seen[:, None] + np.arange(3)).ravel()
    found = reach(SHELL.elastic_at(SHELL.nodes(SPEAKER.vertices)), dofs, true[seen].ravel())
    np.testing.assert_allclose(found[seen], true[seen], atol=1e-8)
    lips = slice(0, 3 * COLUMNS)
    error = np.sqrt(((found - true)[lips] ** 2).sum(axis=1).mean())
    assert error < 0.25 * np.sqrt((true[lips] ** 2).sum(axis=1).mean())
