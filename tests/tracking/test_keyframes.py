"""A head that turns: followed by several references, found again by its texture, not mistaken."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from heads import face_of, head_of, picture_of, seen_at

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.detection.initial_pose import FaceBox, face_marks
from abs_engine.tracking.frame import head_tracking
from abs_engine.tracking.frame.head_tracking import HeadMotion
from abs_engine.tracking.settings.detection import DETECTION
from abs_engine.tracking.settings.registration import REGISTRATION
from abs_engine.tracking.texture import texture_registration
from abs_engine.tracking.texture.rigid_motion import Keyframes, RigidReference, rigid_reference
from abs_engine.tracking.texture.texture_registration import KnownHead

CAMERA = Camera.ideal((480, 360))
SMALL = Camera.ideal((320, 240))
RENDERER = CpuRenderer()
HEAD = head_of("clara")
KNOWN = KnownHead(HEAD.head, HEAD.rigid, SMALL, RENDERER)


def turned(yaw: float) -> Pose:
    """A head turned about its own axis, which swings the face sideways."""
    return seen_at([0, np.radians(yaw), 0], [0, 10, 560])


@cache
def picture(yaw: float, camera: Camera = CAMERA) -> np.ndarray:
    return picture_of(HEAD.head, turned(yaw), camera)


def angle(one: Pose, two: Pose) -> float:
    """Degrees between two heads' rotations."""
    cosine = (np.trace(one.rotation.T @ two.rotation) - 1) / 2
    return float(np.degrees(np.arccos(np.clip(cosine, -1, 1))))


def taken(image: np.ndarray, pose: Pose) -> RigidReference:
    return rigid_reference(image, pose, HEAD.head, HEAD.rigid, CAMERA, RENDERER)


def followed(yaws: list[int], known: Keyframes) -> list[float]:
    """Degrees by which a head that turns is off, infinite where it is lost."""
    states = [known.step(picture(yaw)) for yaw in yaws]
    return [
        np.inf if state is None else angle(state.pose, turned(yaw))
        for yaw, state in zip(yaws, states, strict=True)
    ]


def started() -> Keyframes:
    known = Keyframes(CAMERA, taken)
    known.begin(taken(picture(0), turned(0)))
    return known


# ---- references ----------------------------------------------------------------------------------


@pytest.mark.parametrize("side", [1, -1])
def test_a_head_that_turns_away_and_back_is_followed(side):
    """By 3 degrees each frame; one reference alone loses it before 20."""
    known = started()
    away = [side * yaw for yaw in range(3, 46, 3)]
    assert max(followed(away, known)) < 2
    facing = [r.pose for r in known.references]
    assert 3 <= len(facing) <= 6
    apart = [angle(a, b) for k, a in enumerate(facing) for b in facing[:k]]
    assert min(apart) > np.degrees(REGISTRATION.apart) / 2
    assert angle(known.pose, turned(side * 45)) < 2
    assert max(followed(away[::-2], known)) < 2
    assert len(known.references) == len(facing)  # on the way back they are there already


def test_one_reference_alone_loses_it(monkeypatch):
    monkeypatch.setattr(Keyframes, "_extend", lambda *_: None)
    errors = followed(list(range(3, 46, 3)), started())
    assert np.isinf(errors[-1])


def test_a_head_that_keeps_facing_the_camera_makes_no_references():
    known = started()
    assert max(followed([2, 4, 2, 0, -2, -4, -2], known)) < 1
    assert len(known.references) == 1
    assert known.first is known.references[0]


def test_nothing_is_followed_before_there_is_a_reference():
    known = Keyframes(CAMERA, taken)
    assert known.step(picture(0)) is None
    assert known.first is None
    assert known.pose is None


def test_references_do_not_pile_up_and_the_last_is_in_use():
    known = started()
    reference = known.references[0]
    others = [RigidReference(reference.gray, reference.pixels, reference.points, turned(y))
              for y in range(REGISTRATION.most_references + 3)]  # fmt: skip
    for other in others:
        known.add(other)
    assert len(known.references) == REGISTRATION.most_references
    assert known.first is others[-1]
    assert known.pose is others[-1].pose
    known.begin(reference)
    assert known.references == [reference]


def test_a_picture_without_the_head_is_not_followed_and_the_place_is_kept():
    known = started()
    followed([3, 6], known)
    last = known.pose
    rng = np.random.default_rng(0)
    assert known.step(rng.integers(0, 256, (360, 480, 3), np.uint8)) is None
    assert known.pose is last
    assert followed([6], known)[0] < 2
    assert 0.5 < REGISTRATION.seen_well < 1


# ---- found again ---------------------------------------------------------------------------------


@pytest.mark.parametrize("yaw", [-25, 20])
def test_a_known_head_that_has_turned_is_found_from_where_it_was(yaw):
    """The face is also swung sideways, up to 36 mm, as heads turn about their necks."""
    image = picture(yaw, SMALL)
    found = KNOWN.realign(image, turned(0))
    assert angle(found, turned(yaw)) < 2
    np.testing.assert_allclose(found.translation, turned(yaw).translation, atol=8)
    stayed, there = (KNOWN.error(image, p) for p in (turned(0), found))
    assert there < 0.3 * stayed


@pytest.fixture
def motion(monkeypatch) -> HeadMotion:
    """Follows a face that the user has boxed and that the detector never finds."""
    monkeypatch.setattr(head_tracking, "find_face", lambda _image: None)
    monkeypatch.setattr(head_tracking, "faces_about", lambda *_: [])
    monkeypatch.setattr(KnownHead, "align", lambda _self, _image, _pose: turned(0))
    return HeadMotion(HEAD, SMALL, RENDERER, boxed())


def boxed() -> FaceBox:
    size = SMALL.matrix[0, 0] * DETECTION.box_width / 560
    return FaceBox(160 - size / 2, 120 - size / 2, size)


@pytest.mark.parametrize("jump", [20, -20])
def test_a_head_that_jumps_between_frames_is_found_again(motion, jump):
    yaws = [0, jump, jump]
    poses = [
        pose for _, pose in head_tracking.followed(motion, [picture(yaw, SMALL) for yaw in yaws])
    ]
    assert all(pose is not None for pose in poses)
    assert max(angle(pose, turned(yaw)) for pose, yaw in zip(poses, yaws, strict=True)) < 2.5


def blocks(colour: tuple[int, int, int]) -> np.ndarray:
    """A surface of one colour, unevenly lit, with corners to follow: no face."""
    rng = np.random.default_rng(3)
    light = rng.uniform(0.5, 1.2, (12, 16, 1)).repeat(20, axis=0).repeat(20, axis=1)
    return np.uint8(np.clip(light * colour, 0, 255))


@pytest.mark.parametrize(
    ("colour", "detected"),
    [((128, 128, 128), False), ((196, 148, 122), True), ((60, 110, 190), True)],
)
def test_another_picture_is_not_taken_for_the_head(motion, monkeypatch, colour, detected):
    """Not where the head was, nor where a detector errs; and the head is found again after."""
    face = face_of(face_marks(HEAD), seen_at([0, 0, 0], [0, 20, 560]), SMALL) if detected else None
    monkeypatch.setattr(head_tracking, "find_face", lambda _image: face)
    monkeypatch.setattr(head_tracking, "faces_about", lambda *_: [])
    shown = [picture(0, SMALL), blocks(colour), picture(0, SMALL)]
    found = [pose for _, pose in head_tracking.followed(motion, shown)]
    assert [pose is not None for pose in found] == [True, False, True]
    assert angle(found[2], turned(0)) < 2


# ---- the light's colour --------------------------------------------------------------------------


def in_warm_light(image: np.ndarray) -> np.ndarray:
    """Red up and blue down by a fifth, exposed so that nothing is clipped."""
    return np.uint8(np.rint(0.8 * image * [1.2, 1.0, 0.8]))


def test_a_colour_cast_hardly_moves_the_aligned_pose():
    guess = seen_at([0.02, 0.03, 0], [6, 14, 600])
    plain = picture(0, SMALL)
    poses = [KNOWN.realign(image, guess) for image in (plain, in_warm_light(plain))]
    assert angle(*poses) < 2
    moved = np.abs(poses[1].apply(HEAD.pivot) - poses[0].apply(HEAD.pivot))
    assert (moved < [2, 2, 12]).all()


def test_a_colour_cast_is_taken_off_before_the_comparison(monkeypatch):
    plain = picture(0, SMALL)
    seen = [KNOWN.error(image, turned(0)) for image in (plain, in_warm_light(plain))]
    assert seen[1] < 1.2 * seen[0]
    monkeypatch.setattr(texture_registration, "_balanced", lambda patch, _scene: patch)
    assert KNOWN.error(in_warm_light(plain), turned(0)) > 5 * seen[0]


def test_a_head_is_aligned_from_a_rough_place_in_coloured_light():
    guess = seen_at([0, 0, 0], [4, 6, 650])
    found = KNOWN.align(in_warm_light(picture(0, SMALL)), guess)
    assert angle(found, turned(0)) < 2
    away = found.apply(HEAD.pivot) - turned(0).apply(HEAD.pivot)
    assert np.abs(away[:2]).max() < 2
    assert abs(away[2]) < 15
