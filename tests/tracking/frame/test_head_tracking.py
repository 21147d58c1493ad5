"""The first pass over a clip: the face is found late, lost, and found again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from heads import colours_of, face_of, head_of, picture_of, seen_at

from abs_engine.core.camera import Camera
from abs_engine.core.errors import FaceNotFoundError, ModelFormatError
from abs_engine.core.geometry import Pose
from abs_engine.face.head import build_mouth_model
from abs_engine.io.assets import load_speaker
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.detection.initial_pose import FaceBox, face_marks, pose_of_face
from abs_engine.tracking.frame import head_tracking
from abs_engine.tracking.frame.head_tracking import (
    HeadMotion,
    followed,
)
from abs_engine.tracking.person.frame_choice import choose_frames
from abs_engine.tracking.settings.detection import DETECTION
from abs_engine.tracking.settings.preparation import PREPARATION
from abs_engine.tracking.start.blob_start import mouth_model
from abs_engine.tracking.texture.rigid_motion import Keyframes
from abs_engine.tracking.texture.texture_registration import KnownHead

CAMERA = Camera.ideal((320, 240))
START = seen_at([0, 0, 0], [0, 10, 650])
BLANK = np.full((240, 320, 3), 90, np.uint8)
TEXTURE = np.zeros((8, 8, 3), np.uint8)
SMALL = np.zeros((2, 2, 3), np.uint8)


def test_a_face_that_comes_late_is_learned_from():
    late = [(SMALL, None)] * (PREPARATION.look_at + 50) + [(SMALL, START)] * 40
    assert len(choose_frames(iter(late), "late.mp4")) == PREPARATION.learn_from


def test_frames_after_the_first_ten_seconds_with_a_face_are_not_read():
    read = []

    def frames():
        for k in range(3 * PREPARATION.look_at):
            read.append(k)
            yield SMALL, START

    assert len(choose_frames(frames(), "long.mp4")) == PREPARATION.learn_from
    assert len(read) == PREPARATION.look_at


@pytest.mark.parametrize(
    ("level", "said"),
    [(2, "too dark: 2 of 255"), (251, "too bright: 251 of"), (10, ""), (245, "")],
)
def test_pictures_that_show_nothing_are_named(level, said):
    frames = [(np.full((2, 2, 3), level, np.uint8), None)] * 5
    with pytest.raises(FaceNotFoundError) as caught:
        choose_frames(iter(frames), "night.mp4")
    assert said in str(caught.value)
    assert ("too dark" in str(caught.value) or "too bright" in str(caught.value)) == bool(said)
    assert "a whole frontal face" in str(caught.value)


@pytest.mark.parametrize("seen", [0, 5])
def test_hardly_a_face_is_an_error_that_counts_frames(seen):
    frames = [(SMALL, None)] * 3 + [(SMALL, START)] * seen + [(SMALL, None)] * (60 if seen else 57)
    with pytest.raises(FaceNotFoundError, match=rf"in {len(frames) - seen} of {len(frames)} "):
        choose_frames(iter(frames), "few.mp4")


def test_a_few_faces_at_the_end_of_a_clip_of_something_else_are_none():
    frames = [(SMALL, None)] * 92 + [(SMALL, START)] * 3
    with pytest.raises(FaceNotFoundError, match="in 92 of 95 frames of sky"):
        choose_frames(iter(frames), "sky.mp4")


@pytest.fixture(scope="module")
def clara():
    return head_of("clara")


@pytest.fixture
def motion(clara, monkeypatch):
    """Follows a face that the user has boxed and that the detector never finds."""
    monkeypatch.setattr(head_tracking, "find_face", lambda _image: None)
    monkeypatch.setattr(head_tracking, "faces_about", lambda *_: [])
    monkeypatch.setattr(KnownHead, "align", lambda _self, _image, _pose: START)
    size = CAMERA.matrix[0, 0] * DETECTION.box_width / 650
    return HeadMotion(clara, CAMERA, CpuRenderer(), FaceBox(160 - size / 2, 120 - size / 2, size))


def test_a_boxed_face_is_taken_up_again_where_the_detector_finds_none(clara, motion):
    moved = seen_at([0, 0.06, 0], [4, 12, 650])
    pictures = [picture_of(clara.head, pose, CAMERA) for pose in (START, moved)]
    poses = [p for _, p in followed(motion, [*pictures, BLANK, BLANK, *pictures[::-1]])]
    assert [pose is None for pose in poses] == [False, False, True, True, False, False]
    for pose, true in zip([poses[1], *poses[4:]], [moved, moved, START], strict=True):
        turned = np.degrees(np.arccos((np.trace(pose.rotation.T @ true.rotation) - 1) / 2))
        assert turned < 1.5


def test_a_face_that_comes_back_elsewhere_is_found_by_its_lips(clara, motion, monkeypatch):
    """Too far for its points to be followed; the old reference keeps the head's size."""
    camera = Camera.ideal((640, 240))
    left, right = (seen_at([0, 0, 0], [x, 10, 1300]) for x in (-200, 200))
    monkeypatch.setattr(KnownHead, "align", lambda _self, _image, _pose: left)
    pictures = [picture_of(clara.head, pose, camera) for pose in (left, right)]
    blank = np.full_like(pictures[0], 90)
    shown = [pictures[0], blank, pictures[1]]
    wide = replace(motion, camera=camera, colours=colours_of(clara, left, camera))
    plain = replace(wide, colours=None)
    assert [p is None for _, p in followed(plain, shown)] == [False, True, True]
    poses = [p for _, p in followed(wide, shown)]
    assert [p is None for p in poses] == [False, True, False]
    np.testing.assert_allclose(poses[2].translation, right.translation, atol=20)

    twice = [*shown, pictures[1], blank, pictures[0]]
    poses = [p for _, p in followed(wide, twice)]
    assert [p is None for p in poses] == [False, True, False, False, True, False]
    np.testing.assert_allclose(poses[5].translation, left.translation, atol=20)


@pytest.mark.parametrize(
    ("move", "seen", "person", "kept"),
    [
        ([0, 0, 0], [27, 20], "clara", True),
        ([8, -5, 0], [27, 20], "clara", True),
        ([50, -30, 0], [50, -30], "clara", True),
        ([0, 0, -170], [0, 0], "clara", False),
        ([40, -30, -100], [40, -30], "kofi", False),
    ],
    ids=["stays", "moves", "jumps", "nearer", "another"],
)
def test_a_lost_face_goes_on_from_where_it_moved_to(motion, monkeypatch, move, seen, person, kept):
    """It is seen so many mm beside; where it looks otherwise than before, what is seen decides."""
    monkeypatch.setattr(HeadMotion, "_known", None)
    monkeypatch.setattr(Keyframes, "step", lambda _self, _image: None)
    there = Pose(START.rotation, START.translation + move)
    pictures = [
        picture_of(head.head, pose, CAMERA)
        for head, pose in ((motion.model, START), (head_of(person), there))
    ]
    marks = face_marks(motion.model)
    beside = Pose(START.rotation, START.translation + np.array([*seen, move[2]]))
    found = face_of(marks, beside, CAMERA)
    monkeypatch.setattr(head_tracking, "find_face", lambda _image: found)
    one, two = (pose for _, pose in followed(motion, pictures))
    by_face = pose_of_face(found, CAMERA, marks).translation
    if kept:
        pivot = motion.model.pivot
        was, now, true_was, true = (
            CAMERA.project(pose.apply(pivot)) for pose in (one, two, START, there)
        )
        np.testing.assert_allclose(now - was, true - true_was, atol=1.5)
        assert np.abs(two.translation - by_face).max() > 5
    else:
        np.testing.assert_allclose(two.translation, by_face, atol=1e-6)


@pytest.mark.parametrize("roll", [0.0, 0.4])
def test_a_box_places_the_mouth_of_the_face_that_it_is_about(clara, roll):
    """Its lean and distance are the face's; without a known head's looks, which place it better."""
    somebody = mouth_model(load_speaker(), None)
    pose = seen_at([0, 0, roll], [0, 20, 700])
    image = picture_of(clara.head, pose, CAMERA)
    x, y = CAMERA.project(pose.apply(clara.pivot)) + np.array([0, 6])
    box = FaceBox.around_mouth(x - 30, y - 8, 60, 16)  # twice as wide as the mouth
    ((_, found),) = followed(HeadMotion(somebody, CAMERA, CpuRenderer(), box), [image])
    np.testing.assert_allclose(CAMERA.project(found.apply(somebody.pivot)), [x, y], atol=0.1)
    assert found.angle_to(pose) < 0.15
    assert found.apply(somebody.pivot)[2] == pytest.approx(pose.apply(clara.pivot)[2], rel=0.1)


def test_a_box_on_a_blank_wall_is_no_face(motion):
    assert [p for _, p in followed(motion, [BLANK, BLANK])] == [None, None]


def test_a_speaker_with_other_classes_is_refused():
    speaker = load_speaker()
    names = tuple(name.replace("tongue", "gum") for name in speaker.class_names)
    with pytest.raises(ModelFormatError, match="no facet class tongue"):
        build_mouth_model(replace(speaker, class_names=names), speaker.vertices, TEXTURE)


def test_landmarks_away_from_the_mouth_are_refused():
    speaker = load_speaker()
    far = {**speaker.landmarks, "mouth_corners": np.array([0, speaker.vertices[:, 1].argmax()])}
    with pytest.raises(ModelFormatError, match="landmarks corners"):
        build_mouth_model(replace(speaker, landmarks=far), speaker.vertices, TEXTURE)
