"""The landmarks of the lips that a viewer sees are labelled so."""

from __future__ import annotations

import numpy as np
import pytest

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import FACING, Pose
from abs_engine.io.assets import LIPS_OF_68, load_speaker
from abs_engine.studio.labels import Cover, Geometry, visible
from abs_engine.studio.seam import SLACK, beside, lip_strips

CAMERA = Camera(np.array([[3000.0, 0, 320], [0, 3000, 240], [0, 0, 1]]), (640, 480))
PEOPLE = ["average", "clara", "mei", "walter", "ravi"]
FULL_LIPPED = ["kofi", "amara"]


@pytest.fixture(scope="module")
def speaker():
    return load_speaker()


def posed(speaker, person, yaw=0.0, **units):
    """The head with its mouth before the camera, 600 mm away."""
    head = speaker.vertices if person == "average" else speaker.named(person)
    names, weights = tuple(units), np.array(list(units.values()))
    head = head + np.tensordot(weights, speaker.unit_matrix(names), 1) if names else head
    turned = FACING @ Pose.from_vectors([0, yaw, 0], np.zeros(3)).rotation
    mouth = head[speaker.lip_ring].mean(axis=0)
    points = head @ turned.T + (np.array([0, 0, 600.0]) - turned @ mouth)
    return Geometry.of(CAMERA, points, np.zeros_like(points, np.float32))


def lips_seen(speaker, geometry, covers=()):
    marks = speaker.points["landmark_68"][LIPS_OF_68]
    return visible(marks, geometry, speaker, CAMERA, covers)


@pytest.mark.parametrize("person", PEOPLE)
@pytest.mark.parametrize("opened", [0.0, 0.05, 0.1, 0.35, 0.7])
def test_all_are_seen_from_the_front_closed_and_open(speaker, person, opened):
    assert lips_seen(speaker, posed(speaker, person, jawOpen=opened)).all()


@pytest.mark.parametrize("person", FULL_LIPPED)
@pytest.mark.parametrize("opened", [0.05, 0.1, 0.35])
def test_full_lips_show_them_when_they_part(speaker, person, opened):
    """At rest their upper contact lies more than 5 mm behind the lower lip."""
    assert lips_seen(speaker, posed(speaker, person, jawOpen=opened)).all()
    assert lips_seen(speaker, posed(speaker, person))[[0, 6, 12, 16]].all()  # the corners


def test_the_inner_corners_are_where_the_lips_meet(speaker):
    """Points 60 and 64 lie between the outer corners and the points beside them, near the seam."""
    at = speaker.vertices[speaker.points["landmark_68"]]
    assert at[48, 0] + 0.8 < at[60, 0] < at[61, 0] - 5
    np.testing.assert_allclose(at[60] * [-1, 1, 1], at[64], atol=1e-3)
    assert abs(at[60, 1] - at[48, 1]) < 1


def test_the_far_corner_is_hidden_from_the_side(speaker):
    for yaw, far in ((1.3, [0, 12]), (-1.3, [6, 16])):
        near = [6, 16] if far == [0, 12] else [0, 12]
        seen = lips_seen(speaker, posed(speaker, "average", yaw))
        if seen[far].any():  # the other turn
            far, near = near, far
        assert not seen[far].any()
        assert seen[near].all()


def test_a_hand_before_the_mouth_hides_it(speaker):
    wall = np.array([[-90.0, -90, 480], [90, -90, 480], [90, 90, 480], [-90, 90, 480]])
    cover = Cover(wall, np.array([[0, 1, 2], [0, 2, 3]], np.int32))
    assert not lips_seen(speaker, posed(speaker, "average"), (cover,)).any()


def test_a_strip_is_of_the_points_own_lip(speaker):
    strips, marks = lip_strips(speaker), speaker.points["landmark_68"]
    reds = {
        name: set(speaker.faces[speaker.facet_class == speaker.class_id(name)].ravel().tolist())
        for name in ("upper_lip", "lower_lip")
    }
    for number, lip in ((62, "upper_lip"), (66, "lower_lip")):
        strip = strips[int(marks[number])]
        assert set(strip.tolist()) <= reds[lip]
    points = posed(speaker, "average").points
    near = beside(points, int(marks[62]), strips[int(marks[62])])
    away = points[near] - points[marks[62]]
    assert len(near) > 2
    assert np.linalg.norm(away[:, :2], axis=1).max() < SLACK + 0.2
