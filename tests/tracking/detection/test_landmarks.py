"""The network's landmarks lie where the correspondence puts them on heads that were drawn."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest
from drawn import AHEAD, CAMERA, correspondence, drawn, network_sees, speaker, vertices_of
from heads import SIZE, seen_at
from runs import noise

from abs_engine.core.camera import Camera
from abs_engine.io.assets import shipped
from abs_engine.tracking.detection.face_detection import Face, find_face
from abs_engine.tracking.detection.landmarks import (
    EYES,
    INNER_RING,
    LIPS,
    OUTER_RING,
    Landmarks,
    landmarks_again,
    landmarks_of,
    mirrored,
)

PEOPLE = ["clara", "kofi", "walter", "mei", "amara", "ravi"]


def off_by(seen, person, pose, camera=CAMERA, **units):
    """How far each landmark (468,) lies off the head's own point, mm across the line of sight."""
    there = pose.apply(correspondence().of(vertices_of(person, **units)))
    pixel = there[:, 2].mean() / camera.matrix[0, 0]
    return np.linalg.norm(seen.pixels - camera.project(there), axis=1) * pixel


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def some_face(centre=(60.0, 50.0), size=60.0):
    """A face that a detector might have seen there."""
    x, y = centre
    eyes = [[x - 0.2 * size, y - 0.1 * size], [x + 0.2 * size, y - 0.1 * size]]
    below = [[x, y + 0.1 * size], [x, y + 0.3 * size], [x - 30, y], [x + 30, y]]
    return Face(np.array([x, y]), size, np.array(eyes + below), 1.0)


@pytest.mark.parametrize("person", PEOPLE)
@pytest.mark.parametrize("yaw", [-0.4, 0.0, 0.4])
def test_landmarks_lie_where_the_correspondence_puts_them(person, yaw):
    pose = seen_at([0, yaw, 0], [0, 0, 700])
    seen = network_sees(drawn(person, pose))
    off = off_by(seen, person, pose)
    assert rms(off) < 4.5
    assert rms(off[LIPS]) < 5.0
    assert np.percentile(off, 95) < 9.0
    assert seen.presence > 0.9


def test_a_mirror_image_swaps_the_sides():
    other = mirrored()
    np.testing.assert_array_equal(other[other], np.arange(len(other)))
    assert {int(other[k]) for k in EYES[0]} == set(EYES[1].tolist())
    points = correspondence().of(speaker().vertices.astype(float))
    away = points[other] * [-1, 1, 1] - points
    assert rms(np.linalg.norm(away, axis=1)) < 3.0  # the bundled head is symmetric


@pytest.mark.parametrize("person", PEOPLE[:3])
def test_a_mirror_image_is_seen_alike(person):
    image = drawn(person, seen_at([0.1, 0.3, 0.05], [0, 0, 700]))
    seen, other = (network_sees(np.ascontiguousarray(i)) for i in (image, image[:, ::-1]))
    back = other.points[mirrored()] * [-1, 1, 1] + [image.shape[1] - 1, 0, 0]
    assert rms(back[:, :2] - seen.pixels) < 1.0


def test_two_looks_err_less_than_one():
    """Over people and sides, by how the landmarks of one person lie to each other."""
    errors = []
    for person in PEOPLE:
        for yaw in (-0.4, 0.0, 0.4):
            pose = seen_at([0, yaw, 0], [0, 0, 700])
            image, off = drawn(person, pose), []
            face = find_face(image)
            assert face is not None
            for both in (False, True):
                seen = landmarks_of(image, face, both)
                assert seen is not None
                off.append(rms(off_by(seen, person, pose)))
            errors.append(off)
    one, two = np.mean(errors, axis=0)
    assert two < 0.99 * one


def test_the_places_say_more_than_the_average_face():
    """Else a correspondence that shows nothing of a posture would pass."""
    image = drawn("clara", jawOpen=0.4)
    seen = network_sees(image)
    open_mouth, closed = off_by(seen, "clara", AHEAD, jawOpen=0.4), off_by(seen, "clara", AHEAD)
    assert rms(open_mouth[LIPS]) < 0.7 * rms(closed[LIPS])
    assert seen.openness > 2 * network_sees(drawn("clara")).openness


def test_depth_grows_away_from_the_camera():
    pose = seen_at([0, 0.4, 0], [0, 0, 700])
    depth = network_sees(drawn("ravi", pose)).points[:, 2]
    there = pose.apply(correspondence().of(vertices_of("ravi")))[:, 2]
    assert np.corrcoef(depth, there)[0, 1] > 0.95


@pytest.mark.parametrize("place", [(30, -20, 420), (75, -30, 500)])
def test_a_face_that_is_cut_by_the_pictures_edge(place):
    pose = seen_at([0, 0, 0], place)
    seen = network_sees(drawn("clara", pose))
    inside = ((seen.pixels > 0) & (seen.pixels < np.array(SIZE) - 1)).all(axis=1)
    assert inside.mean() < 0.95  # it is cut
    assert rms(off_by(seen, "clara", pose)[inside]) < 6.0


@pytest.mark.parametrize("roll", [-0.8, 0.0, 0.8])
def test_the_axes_turn_with_the_head(roll):
    seen = network_sees(drawn("mei", seen_at([0, 0, roll], [0, 0, 700])))
    along, down = seen.axes
    assert np.arctan2(along[1], along[0]) == pytest.approx(roll, abs=0.05)
    assert along @ down == pytest.approx(0, abs=1e-12)
    assert down @ (seen.pixels[OUTER_RING].mean(axis=0) - seen.pixels[EYES[0]].mean(axis=0)) > 0


def test_names_of_points():
    """The rings start at the subject's right corner; right is left in the picture."""
    seen = network_sees(drawn("clara"))
    for ring in (OUTER_RING, INNER_RING):
        x, y = seen.pixels[ring].T
        assert x.argmin() == 0
        assert x.argmax() == 10
        assert y[1:10].mean() > y[11:20].mean()
    assert seen.pixels[EYES[0]].mean(axis=0)[0] < seen.pixels[EYES[1]].mean(axis=0)[0]


def test_a_look_from_a_place_that_is_off_comes_to_the_same_points():
    image = drawn("amara")
    seen = network_sees(image)
    began = Landmarks(seen.points + np.array([12.0, -9.0, 0.0]), 1.0)
    distance = []
    for _ in range(3):
        began = landmarks_again(image, began)
        assert began is not None
        distance.append(np.linalg.norm(began.pixels - seen.pixels, axis=1).mean())
    assert distance[-1] < 1.0
    assert off_by(began, "amara", AHEAD).mean() < 4.0


@pytest.mark.parametrize("factor", [0.85, 1.2])
def test_a_look_of_another_size_comes_to_the_same_points(factor):
    image = drawn("kofi")
    seen = network_sees(image)
    centre = seen.points.mean(axis=0)
    again = Landmarks(centre + factor * (seen.points - centre), 1.0)
    for _ in range(3):
        again = landmarks_again(image, again)
        assert again is not None
    assert np.linalg.norm(again.pixels - seen.pixels, axis=1).mean() < 1.0


@pytest.mark.parametrize("factor", [2, 4])
def test_places_count_from_the_centres_of_pixels(factor):
    camera = Camera.ideal((factor * 320, factor * 240))
    small = network_sees(drawn("walter"))
    large = network_sees(drawn("walter", camera=camera))
    off = factor * (small.pixels + 0.5) - 0.5 - large.pixels
    assert np.abs(off.mean(axis=0)).max() < 0.6 * factor  # of a pixel of the small one
    assert np.abs(off_by(large, "walter", AHEAD, camera)).mean() < 4.0


@pytest.mark.parametrize("seed", range(3))
def test_noise_is_no_face(seed):
    assert landmarks_of(noise(1, (120, 100), seed)[0], some_face()) is None


@pytest.mark.parametrize("value", [0, 128, 255])
def test_a_plain_wall_is_no_face(value):
    assert landmarks_of(np.full((100, 120, 3), value, np.uint8), some_face()) is None


@pytest.mark.parametrize("size", [(1, 1), (3, 200), (200, 3)])
def test_a_tiny_picture_is_no_face(size):
    image = np.full((*size, 3), 120, np.uint8)
    for face in (some_face(), some_face((1.0, 1.0), 2.0), some_face((1.0, 1.0), 0.5)):
        assert landmarks_of(image, face) is None


def test_what_is_not_finite_is_no_face():
    face = some_face((np.nan, 50.0))
    assert landmarks_of(drawn("clara"), face) is None


def test_a_face_that_has_left_is_none():
    seen = network_sees(drawn("clara"))
    away = Landmarks(seen.points + np.array([5000.0, 0.0, 0.0]), 1.0)
    assert landmarks_again(drawn("clara"), away) is None
    assert landmarks_again(np.full((240, 320, 3), 90, np.uint8), seen) is None


@pytest.mark.parametrize("name", ["face_mesh", "face_lips", "iris_landmark"])
def test_the_network_is_the_one_that_the_provenance_names(name):
    folder = shipped("detector")
    content = (folder / f"{name}.tflite").read_bytes()
    told = (folder / "PROVENANCE.md").read_text("utf-8")
    assert hashlib.sha256(content).hexdigest() in told
    assert f"{len(content):,} bytes" in told


def test_every_landmark_lies_on_the_bundled_head():
    c, one = correspondence(), speaker()
    np.testing.assert_allclose(c.weights.sum(axis=1), 1.0, atol=1e-6)
    facets = {tuple(facet) for facet in one.faces.tolist()}
    assert all(tuple(corner) in facets for corner in c.corners.tolist())
    assert (c.deviation >= 1.0).all()
    assert np.median(c.deviation[:, :2]) < 4.0
