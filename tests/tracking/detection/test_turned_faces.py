"""Faces in pictures that lie on their side or upside down."""

from __future__ import annotations

import numpy as np
import pytest
from drawn import drawn
from heads import SIZE

from abs_engine.tracking.detection.face_choice import FaceChoice, FaceFollower
from abs_engine.tracking.detection.face_detection import MARKS, faces_any_way_up, faces_turned

BLANK = np.full((SIZE[1], SIZE[0], 3), 100, np.uint8)


def turned(image, quarters):
    """The picture as a camera shows it that was turned with the clock."""
    return np.ascontiguousarray(np.rot90(image, -quarters))


def expected(places, quarters):
    """Places in the upright picture, in the turned one."""
    width, height = SIZE
    for _ in range(quarters):
        places = np.stack([height - 1 - places[..., 1], places[..., 0]], axis=-1)
        width, height = height, width
    return places


@pytest.mark.parametrize("person", ["clara", "kofi", "walter"])
@pytest.mark.parametrize("quarters", [0, 1, 2, 3])
def test_a_face_is_found_whichever_way_up_the_picture_is(person, quarters):
    image = drawn(person)
    upright, seen = (FaceChoice().first(i)[0] for i in (image, turned(image, quarters)))
    off = np.linalg.norm(seen.pixels - expected(upright.pixels, quarters), axis=1)
    assert off.mean() < 0.02 * upright.size
    assert (upright.quarters, seen.quarters) == (0, quarters)


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_its_places_are_those_of_the_picture_as_it_is(quarters):
    image = drawn("clara")
    (upright,), found = faces_turned(image, 0), faces_turned(turned(image, quarters), quarters)
    assert len(found) == 1
    np.testing.assert_allclose(found[0].points, expected(upright.points, quarters), atol=1e-6)
    np.testing.assert_allclose(found[0].centre, expected(upright.centre, quarters), atol=1e-6)
    mouth, eye = (found[0].points[MARKS.index(name)] for name in ("mouth", "right_eye"))
    along = [(0, 1), (-1, 0), (0, -1), (1, 0)][quarters]
    assert (mouth - eye) @ along > 0.3 * found[0].size


def test_upright_faces_are_looked_for_once(monkeypatch):
    image = drawn("clara")
    calls = []
    monkeypatch.setattr(
        "abs_engine.tracking.detection.face_detection.faces_turned",
        lambda *given, **_: calls.append(given) or [],
    )
    assert len(faces_any_way_up(image)) == 1
    assert not calls
    assert faces_any_way_up(BLANK) == []
    assert len(calls) == 3


def test_an_upside_down_face_is_found_again_after_it_was_gone():
    image = turned(drawn("clara"), 2)
    follower = FaceFollower(FaceChoice())
    first = follower.step(image)
    assert follower.step(turned(BLANK, 2)) is None
    again = follower.step(image)
    assert again.quarters == 2
    assert np.linalg.norm(again.pixels - first.pixels, axis=1).mean() < 0.02 * first.size
