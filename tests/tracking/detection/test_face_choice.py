"""Which face is meant where there are several, and that it is followed, not another one."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from drawn import drawn
from heads import SIZE, seen_at

from abs_engine.core.errors import FaceNotFoundError
from abs_engine.tracking.detection import face_choice
from abs_engine.tracking.detection.face_choice import FaceChoice, FaceFollower, by_size, face_lines
from abs_engine.tracking.detection.initial_pose import FaceBox
from abs_engine.tracking.detection.landmarks import OUTER_RING, landmarks_again
from abs_engine.tracking.settings.detection import DETECTION

BLANK = np.full((SIZE[1], 2 * SIZE[0], 3), 100, np.uint8)


@cache
def picture(large="right", shift=0.0):
    """Two people, one nearer; both may be moved to the right by `shift` mm."""
    near = drawn("clara", seen_at([0, 0, 0], [shift, 0, 700]))
    far = drawn("kofi", seen_at([0, 0, 0], [shift, 0, 1100]))
    return np.hstack([far, near] if large == "right" else [near, far])


def side(landmarks):
    """Whether a face lies in the left or the right half of the picture."""
    return "left" if landmarks.pixels[:, 0].mean() < SIZE[0] else "right"


def mouth_box(image, number):
    """Left, top, width and height about the mouth of a face."""
    seen, _ = FaceChoice(number).first(image)
    ring = seen.pixels[OUTER_RING]
    return (*ring.min(axis=0), *np.ptp(ring, axis=0))


@pytest.mark.parametrize("large", ["left", "right"])
def test_the_larger_face_is_taken_and_numbers_count_from_it(large):
    image, other = picture(large), {"left": "right", "right": "left"}[large]
    for number, where in ((None, large), (1, large), (2, other)):
        seen, faces = FaceChoice(number).first(image)
        assert side(seen) == where
        assert len(faces) == 2
        assert faces[0].size > faces[1].size


def test_a_face_that_is_not_there_is_an_error():
    with pytest.raises(FaceNotFoundError, match=r"there is no face 3: .* shows 2 faces") as told:
        FaceChoice(3).first(picture())
    assert str(told.value).endswith("; give --face 1 to 2")
    with pytest.raises(FaceNotFoundError, match="shows 1 face; give --face 1, or leave it out"):
        FaceChoice(2).first(drawn("clara"))


def test_no_face_is_no_error():
    assert FaceChoice(3).first(BLANK) == (None, [])


@pytest.mark.parametrize("number", [1, 2])
def test_the_face_whose_mouth_is_in_the_box(number):
    image = picture()
    box = FaceBox.around_mouth(*mouth_box(image, number))
    seen, faces = FaceChoice(None, box).first(image)
    assert side(seen) == ("right" if number == 1 else "left")
    assert len(faces) == 1


def test_a_box_where_no_face_is():
    box = FaceBox.around_mouth(10.0, 10.0, 30.0, 15.0)
    assert FaceChoice(None, box).first(picture()) == (None, [])


@pytest.mark.parametrize("number", [1, 2])
@pytest.mark.parametrize(("aside", "taken"), [(1.2, True), (5.0, False)])
def test_a_face_beside_the_box_is_taken_where_it_may_lie_there(number, aside, taken):
    image = picture()
    left, top, width, height = mouth_box(image, number)
    box = FaceBox.around_mouth(left, top - aside * width, width, height)
    assert FaceChoice(None, box).first(image) == (None, [])
    seen, _ = FaceChoice(None, box, about=True).first(image)
    assert (seen is not None) is taken
    assert not taken or side(seen) == ("right" if number == 1 else "left")


@pytest.mark.parametrize("number", [None, 2])
def test_the_face_is_followed_while_both_move(number):
    follower = FaceFollower(FaceChoice(number))
    where = [side(follower.step(picture(shift=4.0 * k))) for k in range(4)]
    assert where == ["right" if number is None else "left"] * 4
    assert len(follower.faces) == 2


def test_it_is_followed_through_frames_that_show_nothing():
    follower = FaceFollower(FaceChoice(2))
    first = follower.step(picture())
    for _ in range(5):
        assert follower.step(BLANK) is None
    again = follower.step(picture(shift=10.0))
    assert side(again) == side(first) == "left"
    assert np.linalg.norm(again.pixels - first.pixels, axis=1).mean() > 2.0


def test_a_face_elsewhere_is_not_taken_for_the_one_that_went():
    follower = FaceFollower(FaceChoice(1))
    assert side(follower.step(picture())) == "right"
    alone = picture().copy()
    alone[:, SIZE[0] :] = 100
    assert follower.step(alone) is None
    assert side(follower.step(picture())) == "right"


def test_one_that_stays_away_is_given_up_for_another():
    follower = FaceFollower(FaceChoice(1))
    follower.step(picture())
    alone = picture().copy()
    alone[:, SIZE[0] :] = 100
    seen = [follower.step(alone) for _ in range(54)]
    assert seen[:10] == [None] * 10
    assert side(seen[-1]) == "left"
    taken = 1 + next(k for k, one in enumerate(seen) if one is not None)
    assert (follower.anew, follower.cuts) == ([taken], [1])
    again = FaceFollower(FaceChoice(1), follower.found)
    images = [picture(), *[alone] * 54]
    begun = [again.step(image) is not None and again.cut for image in images]
    assert begun == [k == taken for k in range(55)]
    line = follower.remarks().splitlines()[2]
    assert line.startswith(
        f"after more than {DETECTION.patience} frames without a face, one that may be another "
        f"person's is followed from frame {taken} on"
    )


def test_one_that_comes_back_where_it_was_is_the_same(monkeypatch):
    monkeypatch.setattr(face_choice, "DETECTION", replace(DETECTION, patience=8))
    follower = FaceFollower(FaceChoice())
    follower.step(scene(0))
    empty = scene(0)
    empty[:, : SIZE[0]] = empty[:, SIZE[0] :]
    assert [follower.step(empty) for _ in range(12)] == [None] * 12
    assert follower.step(scene(0)) is not None
    assert (follower.anew, follower.cuts) == ([], [])


def scene(number, place=None):
    """A wall whose pattern differs from scene to scene, with a person at one or the other side."""
    cells = np.random.default_rng(number).integers(40, 200, (6, 16))
    wall = np.repeat(np.repeat(cells, SIZE[1] // 6, 0), 2 * SIZE[0] // 16, 1)[..., None]
    image = np.uint8(np.repeat(wall, 3, 2))
    left = SIZE[0] * (number % 2 if place is None else place) + 96
    image[:, left : left + 128] = drawn("clara" if number < 2 else "kofi")[:, 96:224]
    return image


def test_after_a_cut_the_face_may_be_anywhere_at_once():
    follower = FaceFollower(FaceChoice(None))
    shots = [0, 0, 1, 1, 2]
    assert [side(follower.step(scene(k))) for k in shots] == [
        "left",
        "left",
        "right",
        "right",
        "left",
    ]
    assert follower.cuts == [2, 4]


def test_a_face_is_found_when_it_enters_after_the_cut():
    follower = FaceFollower(FaceChoice(None))
    follower.step(scene(0))
    empty = scene(1)
    empty[:, SIZE[0] :] = empty[:, : SIZE[0]]
    assert follower.step(empty) is None
    assert side(follower.step(scene(1))) == "right"


def test_the_first_face_after_a_cut_may_be_another_than_the_next():
    follower = FaceFollower(FaceChoice())
    shots = [scene(0), scene(1), scene(1, 0), scene(1, 0)]  # farther than a face goes in a frame
    assert [side(follower.step(image)) for image in shots] == ["left", "right", "left", "left"]
    assert follower.cuts == [1]
    settled = FaceFollower(FaceChoice())
    for image in [scene(0), *[scene(1)] * 6]:
        assert settled.step(image) is not None
    assert settled.step(scene(1, 0)) is None


def test_a_face_that_was_chosen_is_not_given_up_at_a_cut():
    follower = FaceFollower(FaceChoice(1))
    assert side(follower.step(scene(0))) == "left"
    assert [follower.step(scene(1)) for _ in range(2)] == [None, None]
    assert side(follower.step(scene(0))) == "left"


def test_a_cut_may_turn_the_picture():
    follower = FaceFollower(FaceChoice())
    follower.step(scene(0))
    turned = follower.step(np.ascontiguousarray(scene(1)[::-1, ::-1]))
    assert (side(turned), turned.quarters) == ("left", 2)


def test_a_box_in_a_turned_picture():
    image = np.ascontiguousarray(np.rot90(picture(), 2))
    ring = FaceChoice(1).first(image)[0].pixels[OUTER_RING]
    box = FaceBox.around_mouth(*ring.min(axis=0), *np.ptp(ring, axis=0))
    assert side(FaceChoice(None, box).first(image)[0]) == "left"


def test_remarks_on_faces_and_cuts():
    follower = FaceFollower(FaceChoice())
    follower.step(picture())
    assert follower.remarks().startswith("2 faces: ")
    for k in (0, 1):
        follower.step(scene(k))
    lines = follower.remarks().splitlines()
    assert len(lines) == 2
    assert lines[1].startswith("the film is cut before frames 1, 2: ")
    alone = FaceFollower(FaceChoice())
    alone.step(scene(0))
    assert alone.remarks() == ""


def test_the_first_frames_may_show_nobody():
    follower = FaceFollower(FaceChoice(None))
    assert follower.step(BLANK) is None
    assert follower.faces == []
    assert follower.step(picture()) is not None


def test_faces_are_told_by_where_they_are():
    _, faces = FaceChoice().first(picture())
    line = face_lines(faces, 1)
    x, y = faces[0].centre
    assert line.startswith(f"2 faces: 1 at {x:.0f} {y:.0f}, {faces[0].size:.0f} pixels; 2 at ")
    assert line.endswith("following face 1 (the largest); 'track --face N' follows another")
    assert "following face 2; 'track" in face_lines(faces, 2)
    assert by_size(faces[::-1]) == faces


@pytest.mark.parametrize("move", [40.0, 80.0, -100.0])
def test_landmarks_do_not_stay_beside_a_face_that_moves_fast(move):
    """The network is as sure of points beside a face."""
    follower = FaceFollower(FaceChoice())
    before, after = (drawn("clara", seen_at([0, 0, 0], [x, 0, 700])) for x in (-move / 2, move / 2))
    follower.step(before)
    for _ in range(2):
        seen, fresh = follower.step(after), FaceChoice().first(after)[0]
        if seen is not None:
            assert np.linalg.norm(seen.pixels - fresh.pixels, axis=1).mean() < 0.02 * fresh.size
    assert seen is not None


@pytest.mark.parametrize("beside", [0.4, 0.5, 0.6, 0.8])
def test_points_beside_a_face_are_none_or_lie_elsewhere_in_the_mirror_image(beside):
    image = drawn("clara", seen_at([0, 0, 0], [0, 0, 700]))
    seen = FaceChoice().first(image)[0]
    assert seen.unlike < 0.03
    there = replace(seen, points=seen.points + np.array([beside * seen.size, 0, 0]))
    found = landmarks_again(image, there)
    if found is not None and found.unlike < 0.03:  # then another look finds the face
        found = landmarks_again(image, found)
        off = np.linalg.norm(found.pixels - seen.pixels, axis=1).mean()
        assert off < 0.03 * seen.size


def test_a_neighbour_close_by_is_not_taken_for_a_face_that_went():
    pair = np.hstack([drawn("kofi")[:, 96:224], drawn("clara")[:, 96:224]])
    follower = FaceFollower(FaceChoice(1))
    gone, where = pair.copy(), follower.step(pair).pixels[:, 0].mean() > 128
    gone[:, 128:] = np.where(where, 100, pair[:, 128:])
    gone[:, :128] = np.where(where, pair[:, :128], 100)
    assert [follower.step(gone) for _ in range(3)] == [None] * 3


def passing(x, kind="kofi"):
    """Somebody's head before a person who stays, `x` pixels from the picture's left."""
    image = np.hstack([BLANK, BLANK])[:, : 3 * SIZE[0]].copy()
    image[:, SIZE[0] : 2 * SIZE[0]] = drawn("clara")
    left, right = max(0, x), min(image.shape[1], x + 128)
    if left < right:
        image[:, left:right] = drawn(kind)[:, 96 + left - x : 96 + right - x]
    return image


def test_somebody_who_passes_before_the_face_does_not_take_the_follower_along():
    follower = FaceFollower(FaceChoice())
    there, found = follower.step(passing(-200)).pixels.mean(axis=0), []
    for x in range(-180, 3 * SIZE[0], 20):
        seen = follower.step(passing(x))
        found.append(seen is not None)
        if seen is not None:
            assert np.linalg.norm(seen.pixels.mean(axis=0) - there) < 0.5 * seen.size
    assert 0 < found.count(False) < 20
    assert all(found[-10:])
    assert (follower.anew, follower.cuts) == ([], [])


def test_somebody_who_stays_before_the_face_is_followed_in_time_and_named():
    follower = FaceFollower(FaceChoice())
    for x in range(-200, SIZE[0] + 96, 20):
        follower.step(passing(x))
    for _ in range(DETECTION.patience + 5):
        seen = follower.step(passing(SIZE[0] + 96))
    assert seen is not None
    assert len(follower.anew) == 1


@pytest.mark.parametrize(("kind", "known"), [("clara", True), ("kofi", False)])
def test_a_face_that_comes_back_elsewhere_is_known_by_its_look(kind, known):
    follower, empty = FaceFollower(FaceChoice()), scene(0)
    follower.step(empty.copy())
    empty[:, : SIZE[0]] = empty[:, SIZE[0] :]
    for _ in range(8):
        assert follower.step(empty) is None
    empty[:, SIZE[0] + 96 : SIZE[0] + 224] = drawn(kind)[:, 96:224]
    assert (follower.step(empty) is not None) is known
    assert (follower.anew, follower.cuts) == ([], [])
