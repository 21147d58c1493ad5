"""Points of the surface come back from sightings that were made without the network."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import islice

import numpy as np
import pytest
from drawn import CAMERA, correspondence, projected, speaker, texture_of, vertices_of
from heads import seen_at

from abs_engine.core.errors import FaceNotFoundError, ModelFormatError
from abs_engine.core.geometry import vertex_normals
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.detection.landmarks import COUNT, INNER_RING, LIPS
from abs_engine.tracking.landmark.landmark_correspondence import (
    FILE,
    Sighting,
    learn_correspondence,
    load_correspondence,
)
from abs_engine.tracking.landmark.rendered_landmarks import sightings_of
from abs_engine.tracking.settings.landmarks import LANDMARK_EVIDENCE

NOISE = 1.5  # mm
TURNS = [(p, y) for p in (-0.2, 0.15) for y in (-0.5, 0.0, 0.5)]


def sightings(noise=NOISE):
    """Two heads from several sides, whose landmarks are where the bundled file says."""
    out = []
    for person, units in ((None, {}), ("clara", {"jawOpen": 0.3})):
        vertices = vertices_of(person, **units)
        points = correspondence().of(vertices)
        for pitch, yaw in TURNS:
            pose = seen_at([pitch, yaw, 0], [0, 0, 700])
            seen = projected(points, pose, noise=noise, seed=len(out) + 1)
            out.append(Sighting(vertices, pose, CAMERA, seen))
    return out


@cache
def learned(noise=NOISE):
    return learn_correspondence(speaker(), sightings(noise))


def shown():
    """Which landmarks (468,) look forward on the average head."""
    normals = vertex_normals(speaker().vertices.astype(np.float64), speaker().faces)
    return correspondence().of(normals)[:, 2] > 0.5


def apart(found, vertices):
    """Distance (468,) of the points that were found from the true ones, mm."""
    return np.linalg.norm(found.of(vertices) - correspondence().of(vertices), axis=1)


def test_the_points_come_back():
    off = apart(learned(), speaker().vertices)[shown()]
    assert np.median(off) < 1.0
    assert np.percentile(off, 95) < 2.5


def test_they_come_back_on_another_person_in_another_posture():
    vertices = vertices_of("kofi", mouthSmileLeft=0.6, mouthSmileRight=0.6)
    assert np.median(apart(learned(), vertices)[shown()]) < 1.0


def test_inner_rings_stay_on_their_own_lips():
    """Where lips meet, the nearest surface may be the other lip's: it would move with it."""
    one = speaker()
    open_wide = vertices_of(None, jawOpen=0.5)
    points = learned().of(open_wide)
    lower, upper = points[INNER_RING[1:10]], points[INNER_RING[11:20][::-1]]
    assert (upper[2:7, 1] - lower[2:7, 1]).min() > 5.0  # mm
    classes = {
        name: {tuple(f) for f in one.faces[one.facet_class == one.class_id(name)].tolist()}
        for name in ("upper_lip", "lower_lip")
    }
    corners = learned().corners
    assert all(tuple(c) in classes["lower_lip"] for c in corners[INNER_RING[1:10]].tolist())
    assert all(tuple(c) in classes["upper_lip"] for c in corners[INNER_RING[11:20]].tolist())


def test_the_deviation_is_the_noise_that_was_added():
    deviation = np.median(learned().deviation[shown()], axis=0)
    np.testing.assert_allclose(deviation[:2], NOISE, rtol=0.25)


def test_no_deviation_is_less_than_the_least():
    """A landmark that hardly any side shows may agree by chance."""
    exact = learned(0.0).deviation
    assert (exact >= LANDMARK_EVIDENCE.least_deviation).all()
    assert np.median(exact) == LANDMARK_EVIDENCE.least_deviation


def test_it_comes_back_from_its_file(tmp_path):
    learned().save(tmp_path / FILE)
    again = load_correspondence(replace(speaker(), folder=tmp_path))
    np.testing.assert_array_equal(again.corners, learned().corners)
    np.testing.assert_allclose(again.weights, learned().weights, atol=1e-6)
    np.testing.assert_allclose(again.deviation, learned().deviation, rtol=1e-6)


def test_a_folder_without_a_file_has_none(tmp_path):
    assert load_correspondence(replace(speaker(), folder=tmp_path)) is None


@pytest.mark.parametrize("kind", ["fewer vertices", "fewer landmarks", "negative"])
def test_another_mesh_is_refused(tmp_path, kind):
    one, corners = correspondence(), correspondence().corners
    if kind == "fewer landmarks":
        one = replace(one, corners=corners[:100], weights=one.weights[:100])
    elif kind == "negative":
        one = replace(one, corners=np.where(np.arange(COUNT)[:, None] == 7, -1, corners))
    one.save(tmp_path / FILE)
    most = int(corners.max()) if kind == "fewer vertices" else len(speaker().vertices)
    other = replace(speaker(), folder=tmp_path, vertices=speaker().vertices[:most])
    with pytest.raises(
        ModelFormatError, match=r"'corners' of .*; make it again with assets/make_lan"
    ):
        load_correspondence(other)


def test_too_few_sightings_are_refused():
    some = sightings()[: LANDMARK_EVIDENCE.least_sightings - 1]
    with pytest.raises(FaceNotFoundError, match=r"sees no face in drawings .*--start blobs"):
        learn_correspondence(speaker(), some)


def test_displacements_are_taken_as_points_are():
    one, vertices = correspondence(), speaker().vertices
    moved = speaker().unit_matrix(("jawOpen",))
    both = one.of(vertices + moved)
    np.testing.assert_allclose(both, one.of(vertices) + one.of(moved), atol=1e-3)
    assert np.linalg.norm(one.of(moved)[0, LIPS], axis=1).max() > 5.0


def test_drawings_of_a_head_are_seen_from_its_sides():
    vertices = vertices_of("mei")
    seen = list(
        islice(
            sightings_of(speaker(), vertices, texture_of("mei"), CpuRenderer()),
            len(LANDMARK_EVIDENCE.drawn_yaws),
        )
    )
    turns = {round(float(np.arcsin(s.pose.rotation[0, 2])), 2) for s in seen}
    assert turns == set(LANDMARK_EVIDENCE.drawn_yaws)
    for one in seen:
        there = one.pose.apply(correspondence().of(vertices))
        pixel = there[:, 2].mean() / one.camera.matrix[0, 0]
        off = np.linalg.norm(one.landmarks.pixels - one.camera.project(there), axis=1) * pixel
        assert np.median(off) < 5.0
