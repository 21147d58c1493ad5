"""People's heads on the bundled head's mesh: nothing tears, and what sets people apart is kept."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.distance import pdist

from abs_engine.core.errors import ModelFormatError
from abs_engine.face.identity import sized_head
from abs_engine.face.settings.shape import SHAPE
from abs_engine.face.shape import population
from abs_engine.face.shape.population import Population, average_person, load_population
from abs_engine.io.assets import load_speaker
from abs_engine.tracking.person.scale import pupil_distance

SPEAKER = load_speaker()
V = SPEAKER.vertices.astype(np.float64)


def fields():
    found = load_population()
    return np.concatenate([found.mean[None], found.components]).astype(np.float64)


def test_copies_at_seams_of_the_texture_stay_together():
    _, first, of_vertex = np.unique(SPEAKER.weld, return_index=True, return_inverse=True)
    assert np.abs(fields() - fields()[:, first[of_vertex]]).max() < 0.01


def test_lips_that_touch_go_along_together():
    upper, lower = (SPEAKER.vertices_of(name) for name in ("upper_lip", "lower_lip"))
    away = np.linalg.norm(V[upper][:, None] - V[lower], axis=2)
    nearest = lower[away.argmin(axis=1)]
    touching = (away.min(axis=1) < 0.5) & (SPEAKER.weld[upper] != SPEAKER.weld[nearest])
    assert touching.sum() > 20
    apart = fields()[:, upper[touching]] - fields()[:, nearest[touching]]
    assert np.linalg.norm(apart, axis=2).max() < 0.5


def test_the_two_sides_of_a_face_are_alike():
    other_side = np.array([-1.0, 1.0, 1.0])
    away, across = cKDTree(V).query(V * other_side)
    alike = away < 1e-3
    assert alike.mean() > 0.95
    off = fields()[:, alike] - fields()[:, across[alike]] * other_side
    assert np.abs(off).max() < 0.05


def test_eyes_move_as_a_whole():
    eyes = SPEAKER.vertices_of("eyes")
    for side in (-1, 1):
        own = eyes[side * V[eyes, 0] > 0]
        moved = fields()[1:, own]
        assert np.abs(moved - moved[:, :1]).max() < 0.02
        before, after = (pdist(vertices[own]) for vertices in (V, V + fields()[0]))
        some = before > 0.1  # not copies at seams
        assert np.ptp(after[some] / before[some]) < 0.02


def test_the_average_head_has_its_pupils_as_far_apart():
    whole = V + fields()[0]
    assert pupil_distance(SPEAKER, whole) == pytest.approx(pupil_distance(SPEAKER, V), rel=1e-3)


def test_an_unknown_person_is_expected_between_an_artists_head_and_people():
    moved = average_person().vertices - load_population().slide.of(SPEAKER.vertices)
    np.testing.assert_allclose(moved, SHAPE.scanned * fields()[0], atol=1e-4)


def test_noses_of_people_stand_out_farther_than_the_artists():
    marks = SPEAKER.points["landmark_68"]
    tip, corners = marks[30], marks[[36, 39, 42, 45]]

    def length(vertices):
        return vertices[tip, 2] - vertices[corners, 2].mean()

    assert length(V + fields()[0]) > length(V) + 3.0


def test_a_person_of_the_model_lies_within_what_is_expected():
    """A made-up person of the components is explained better than by the targets alone."""
    rng = np.random.default_rng(0)
    person = average_person()
    weights = rng.normal(size=len(load_population().components))
    wanted = np.tensordot(weights, fields()[1:], 1).ravel()
    left = []
    for modes in (sized_head(person, 1.0)[1], sized_head(SPEAKER, 1.0)[1]):
        flat = modes.reshape(len(modes), -1).astype(np.float64)
        system = np.vstack([flat.T, np.eye(len(flat))])
        own = np.linalg.lstsq(system, np.r_[wanted, np.zeros(len(flat))], rcond=None)[0]
        left.append(np.sqrt(((wanted - own @ flat) ** 2).mean()))
    assert left[0] < 0.9 * left[1]


def test_a_file_of_another_mesh_is_refused(tmp_path, monkeypatch):
    found = load_population()
    short = Population(found.slide, found.mean[:-1], found.components[:, :-1])
    short.save(tmp_path / "heads.npz")
    monkeypatch.setattr(population, "shipped", lambda name: tmp_path / "heads.npz")
    with pytest.raises(ModelFormatError, match="make it again with assets/make_population"):
        load_population.__wrapped__.__wrapped__()


def test_components_are_as_much_larger_as_the_head():
    none = np.zeros((0, *V.shape), np.float32)
    usual, larger = (load_population().pooled([none], factor) for factor in (1.0, 1.1))
    np.testing.assert_allclose(larger, 1.1 * usual, rtol=1e-5)
    assert np.sqrt((usual**2).sum(axis=2).mean(axis=1)).min() > 0.05  # mm: none is empty


def heights_beside_the_corner(vertices):
    """Of the upper and of the lower lip a millimetre from the right corner, mm."""
    ring, corners = SPEAKER.lip_ring, SPEAKER.landmarks["mouth_corners"]
    left = int(np.flatnonzero(ring == corners[1])[0])
    found = []
    for half in (ring[: left + 1], np.r_[ring[:1], ring[:left:-1]]):
        x, y, _ = (vertices[half] - vertices[corners[0]]).T
        found.append(abs(np.interp(1.0, np.maximum.accumulate(x), y)))
    return np.array(found)


def test_the_lips_of_people_end_in_a_point_where_the_artists_are_blunt():
    artists, peoples = (heights_beside_the_corner(v) for v in (V, average_person().vertices))
    assert artists.min() > 3.0
    assert peoples.max() < 2.5
    middle = SPEAKER.landmarks["outer_lip_20"][[3, 9]]
    moved = load_population().slide.of(V) - V
    assert np.abs(moved[middle]).max() < 0.05  # lips stay as thick


def test_vertices_slide_along_edges_of_the_surface():
    slide = load_population().slide
    faces = SPEAKER.faces
    edges = {frozenset(e) for k in range(3) for e in faces[:, [k, (k + 1) % 3]].tolist()}
    assert all(frozenset(pair) in edges for pair in slide.between.tolist())
    moved = np.linalg.norm(slide.of(V) - V, axis=1)
    assert 1.0 < moved.max() < 4.0


def test_no_facet_of_the_mouth_turns_over_where_vertices_slide():
    near = np.isin(SPEAKER.faces, load_population().slide.vertices).any(axis=1)

    def normals(vertices):
        one, two, three = (vertices[SPEAKER.faces[near, k]] for k in range(3))
        return np.cross(two - one, three - one)

    assert (np.sum(normals(V) * normals(average_person().vertices), axis=1) > 0).all()


def test_both_sides_of_the_lips_slide_alike():
    other_side = np.array([-1.0, 1.0, 1.0])
    across = cKDTree(V).query(V * other_side)[1]
    moved = load_population().slide.of(V) - V
    np.testing.assert_allclose(moved, moved[across] * other_side, atol=0.02)


def test_what_moves_a_head_slides_with_it():
    """A unit opens a person's jaw as far as it opens the artist's, on the same surface."""
    slide, person = load_population().slide, average_person()
    k = SPEAKER.unit_names.index("jawOpen")
    opened = SPEAKER.vertices + SPEAKER.units[k]
    np.testing.assert_allclose(
        slide.of(SPEAKER.vertices) + person.units[k], slide.of(opened), atol=0.02
    )
    np.testing.assert_array_equal(person.identity, slide.of(SPEAKER.identity))
