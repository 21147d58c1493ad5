"""The first pass over a clip: the face is found late, lost, and found again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from heads import colours_of, head_of, picture_of, seen_at

from abs_engine.assets import load_speaker
from abs_engine.camera import Camera
from abs_engine.errors import FaceNotFoundError, ModelFormatError
from abs_engine.geometry import Pose
from abs_engine.render.cpu import CpuRenderer
from abs_engine.track import prepare
from abs_engine.track.align import KnownHead
from abs_engine.track.keyframes import Keyframes
from abs_engine.track.locate import BOX_WIDTH_MM, FaceBox, first_pose
from abs_engine.track.model import build_mouth_model
from abs_engine.track.prepare import LEARN_FROM, LOOK_AT, HeadMotion, choose_frames

CAMERA = Camera.ideal((320, 240))
START = seen_at([0, 0, 0], [0, 10, 650])
BLANK = np.full((240, 320, 3), 90, np.uint8)
TEXTURE = np.zeros((8, 8, 3), np.uint8)
SMALL = np.zeros((2, 2, 3), np.uint8)


def test_a_face_that_comes_late_is_learned_from():
    late = [(SMALL, None)] * (LOOK_AT + 50) + [(SMALL, START)] * 40
    assert len(choose_frames(iter(late), "late.mp4")) == LEARN_FROM


def test_frames_after_the_first_ten_seconds_with_a_face_are_not_read():
    read = []

    def frames():
        for k in range(3 * LOOK_AT):
            read.append(k)
            yield SMALL, START

    assert len(choose_frames(frames(), "long.mp4")) == LEARN_FROM
    assert len(read) == LOOK_AT


@pytest.mark.parametrize("seen", [0, 5])
def test_hardly_a_face_is_an_error_that_counts_frames(seen):
    frames = [(SMALL, None)] * 3 + [(SMALL, START)] * seen + [(SMALL, None)] * (60 if seen else 57)
    with pytest.raises(FaceNotFoundError, match=rf"in {len(frames) - seen} of {len(frames)} "):
        choose_frames(iter(frames), "few.mp4")


@pytest.fixture(scope="module")
def clara():
    return head_of("clara")


@pytest.fixture
def motion(clara, monkeypatch):
    """Follows a face that the user has boxed and that the detector never finds."""
    monkeypatch.setattr(prepare, "find_face", lambda _image: None)
    monkeypatch.setattr(prepare, "find_faces", lambda _image: [])
    monkeypatch.setattr(KnownHead, "align", lambda _self, _image, _pose: START)
    size = CAMERA.matrix[0, 0] * BOX_WIDTH_MM / 650
    return HeadMotion(clara, CAMERA, CpuRenderer(), FaceBox(160 - size / 2, 120 - size / 2, size))


def test_a_boxed_face_is_taken_up_again_where_the_detector_finds_none(clara, motion):
    moved = seen_at([0, 0.06, 0], [4, 12, 650])
    pictures = [picture_of(clara.head, pose, CAMERA) for pose in (START, moved)]
    poses = [p for _, p in motion.poses([*pictures, BLANK, BLANK, *pictures[::-1]])]
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
    shown = [pictures[0], np.full_like(pictures[0], 90), pictures[1]]
    wide = replace(motion, camera=camera, colours=colours_of(clara, left, camera))
    plain = replace(wide, colours=None)
    assert [p is None for _, p in plain.poses(shown)] == [False, True, True]
    poses = [p for _, p in wide.poses(shown)]
    assert [p is None for p in poses] == [False, True, False]
    np.testing.assert_allclose(poses[2].translation, right.translation, atol=20)


@pytest.mark.parametrize(
    ("move", "box", "person", "kept"),
    [
        ([0, 0, 0], [27, 20], "clara", True),
        ([8, -5, 0], [27, 20], "clara", True),
        ([50, -30, 0], [50, -30], "clara", True),
        ([0, 0, -170], [0, 0], "clara", False),
        ([40, -30, -100], [40, -30], "kofi", False),
    ],
    ids=["stays", "moves", "jumps", "nearer", "another"],
)
def test_a_lost_face_goes_on_from_where_it_moved_to(motion, monkeypatch, move, box, person, kept):
    """Its box wanders by so many mm; where it looks otherwise than before, the box decides."""
    monkeypatch.setattr(HeadMotion, "_known", None)
    monkeypatch.setattr(Keyframes, "step", lambda _self, _image: None)
    there = Pose(START.rotation, START.translation + move)
    pictures = [
        picture_of(head.head, pose, CAMERA)
        for head, pose in ((motion.model, START), (head_of(person), there))
    ]
    depth = there.translation[2]
    x, y = np.array(box) * CAMERA.matrix[0, 0] / depth
    size = motion.box.size * 650 / depth
    middle = motion.box.x + motion.box.size / 2, motion.box.y + motion.box.size / 2
    found = FaceBox(middle[0] + x - size / 2, middle[1] + y - size / 2, size)
    monkeypatch.setattr(prepare, "find_face", lambda _image: found)
    one, two = (pose for _, pose in motion.poses(pictures))
    by_box = first_pose(found, CAMERA, motion.model.pivot).translation
    if kept:
        pivot = motion.model.pivot
        was, seen, true_was, true = (
            CAMERA.project(pose.apply(pivot)) for pose in (one, two, START, there)
        )
        np.testing.assert_allclose(seen - was, true - true_was, atol=1.5)
        assert np.abs(two.translation - by_box).max() > 5
    else:
        np.testing.assert_allclose(two.translation, by_box, atol=1e-6)


def test_a_box_on_a_blank_wall_is_no_face(motion):
    assert [p for _, p in motion.poses([BLANK, BLANK])] == [None, None]


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
