"""Mouths that are drawn beside the face's, or of another size, are noticed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from drawn import drawn, network_sees
from heads import seen_at
from runs import lost_result, toy_result, toy_setting

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.fit.opening import NAME as OPENING
from abs_engine.tracking.detection.landmarks import OUTER_RING
from abs_engine.tracking.results import mouth_check
from abs_engine.tracking.results.mouth_check import MouthCheck
from abs_engine.tracking.runs.recorder import Recorder
from abs_engine.tracking.settings.doubts import DOUBTS

IMAGE = drawn("clara", seen_at([0, 0, 0], [0, 0, 700]))
CAMERA = Camera.ideal((IMAGE.shape[1], IMAGE.shape[0]))
BLANK = np.full_like(IMAGE, 100)


def setting(rate=25.0, **changes):
    """The average head's, before the picture's camera."""
    return replace(toy_setting(), camera=CAMERA, rate=rate, **changes)


def result(index=0, right=0.0, larger=1.0):
    """The mouth where the picture shows it, or so many mm beside it, or as much larger."""
    found = toy_result(index)
    ring = network_sees(IMAGE).pixels[OUTER_RING]
    count = setting().face.ring_sizes[0]
    outer, middle = found.lips[:count], found.lips[:count].mean(axis=0)
    lips = middle + larger * (found.lips - middle)
    width = np.ptp(outer[:, 0])
    depth = CAMERA.matrix[0, 0] * width / np.ptp(ring[:, 0])
    facing = found.pose.rotation
    at = (ring.min(axis=0) + ring.max(axis=0)) / 2
    centre = (outer.min(axis=0) + outer.max(axis=0)) / 2
    ray = np.r_[(at - CAMERA.matrix[:2, 2]) / CAMERA.matrix[0, 0], 1.0]
    pose = Pose(facing, depth * ray + [right, 0, 0] - facing @ centre)
    return replace(found, lips=lips, pose=pose)


def warned(results, image=IMAGE, made=None):
    check = MouthCheck(made or setting())
    for one in results:
        check.add(image, one)
    return check.warnings()


@pytest.mark.parametrize(
    ("changes", "elsewhere"),
    [
        ({}, False), ({"right": 3.0}, False), ({"right": 12.0}, True), ({"right": -12.0}, True),
        ({"right": 60.0}, True), ({"larger": 0.9}, False), ({"larger": 1.15}, False),
        ({"larger": 0.55}, True), ({"larger": 1.6}, True),
    ],
)  # fmt: skip
def test_a_mouth_elsewhere_or_of_another_size(changes, elsewhere):
    said = warned([result(**changes)])
    assert len(said) == elsewhere
    assert all(line.startswith("in 1 of 1 frame in which a landmark network") for line in said)


def test_a_mouth_on_one_of_several_faces_is_in_its_place(monkeypatch):
    one = network_sees(IMAGE)
    other = replace(one, points=one.points + np.array([400.0, 0, 0]))
    for faces, elsewhere in (([one, other], 0), ([other, one], 0), ([other, other], 1)):
        monkeypatch.setattr(mouth_check, "faces_seen", lambda _, f=faces: [(None, k) for k in f])
        assert len(warned([result()])) == elsewhere


def test_most_of_the_frames_count():
    apart = round(DOUBTS.look_apart * 25)
    beside = [result(k * apart, right=40.0) for k in range(2)]
    right = [result((2 + k) * apart) for k in range(2)]
    assert warned([*beside, *right]) == []
    assert warned([*beside, *right[:1]])[0].startswith("in 2 of 3 frames in which")


def open_by(openness):
    """The picture's face, as if its lips were so far apart."""
    seen = network_sees(IMAGE).points.copy()
    across = np.linalg.norm(seen[263, :2] - seen[33, :2])
    seen[14] = seen[13] + [0, openness * across, 0]
    return None, replace(network_sees(IMAGE), points=seen)


def test_a_mouth_that_is_drawn_closed_and_seen_open(monkeypatch):
    def said(openness, frames, aperture=0.0, beside=()):
        faces = [open_by(openness), *map(open_by, beside)]
        monkeypatch.setattr(mouth_check, "faces_seen", lambda _image: faces)
        return warned([replace(result(k * apart), aperture=aperture) for k in range(frames)])

    apart = round(DOUBTS.look_apart * 25)
    assert said(0.1, 3)[0].startswith("in 3 of 3 frames in which")
    assert "it is drawn closed, and seen open: look" in said(0.1, 3)[0]
    assert said(0.1, 3, aperture=4.0) == said(0.02, 3) == said(0.1, 1) == []
    assert said(0.1, 3, beside=[0.02]) == []  # which of the two is drawn is not known


def test_learned_lips_that_cannot_open_are_noticed_though_landmarks_place_the_head(monkeypatch):
    apart = round(DOUBTS.look_apart * 25)
    opened = open_by(0.1)
    monkeypatch.setattr(mouth_check, "faces_seen", lambda _image: [opened])
    closed = [replace(result(k * apart, right=40.0), aperture=0.0) for k in range(3)]
    placed = setting(landmarks=object(), learned_lips=True)
    opening = [replace(one, aperture=4.0, index=one.index + 1) for one in closed]
    both = sorted([*closed, *opening], key=lambda one: one.index)
    (said,) = warned(both, made=placed)
    assert said.startswith("in 3 of 3 frames that were looked at, of those in which the mouth is")
    assert "sees it open" in said
    assert "--physics" in said
    assert warned(opening, made=placed) == warned(closed[:1], made=placed) == []
    assert warned(closed, made=setting(landmarks=object())) == []
    opened = open_by(0.02)
    assert warned(closed, made=placed) == []


@pytest.mark.parametrize("placed", [None, object()])
def test_learned_lips_that_hardly_move_are_noticed_though_they_are_open(placed, monkeypatch):
    made, apart = setting(landmarks=placed, learned_lips=True), round(DOUBTS.look_apart * 25)

    def said(apertures, openness, made=made, beside=()):
        left = iter(openness)
        monkeypatch.setattr(
            mouth_check, "faces_seen", lambda _: [*map(open_by, beside), open_by(next(left))]
        )
        looked = enumerate(apertures)
        return warned([replace(result(k * apart), aperture=a) for k, a in looked], made=made)

    moving = [0.0, 0.1, 0.05, 0.1, 0.0, 0.1]
    still, following = [3.0, 3.1, 3.0, 3.1, 3.0, 3.0], [110 * x + 2 for x in moving]
    (line,) = said(still, moving)
    assert line.startswith("in 6 frames that were looked at the aperture varies by 0.0 mm; by how")
    assert "it should by about 5 mm: look" in line
    assert said(following, moving) == said(still, [0.05] * 6) == said(still[:4], moving[:4]) == []
    assert said(still, moving, made=setting(landmarks=placed)) == []
    assert said(still, moving, beside=[0.0]) == []  # which of the two is drawn is not known


def test_lost_frames_and_pictures_without_a_face_do_not_count():
    assert warned([lost_result(k) for k in range(30)]) == []
    assert warned([result(right=40.0)], BLANK) == []
    check, apart = MouthCheck(setting()), round(DOUBTS.look_apart * 25)
    for k in range(3):  # one face in three looks may be none
        check.add(BLANK if k else IMAGE, result(k * apart, right=40.0))
    assert check.warnings() == []


def test_heads_by_landmarks_and_close_ups_are_not_looked_at(monkeypatch):
    monkeypatch.setattr(mouth_check, "faces_seen", lambda _image: pytest.fail("looked at"))
    beside = [result(right=40.0)]
    assert warned(beside, made=setting(landmarks=object())) == []
    worn = setting(face=toy_setting().face.looking(**{OPENING: object()}))
    assert warned(beside, made=worn) == []


@pytest.mark.parametrize("face", [True, False])
def test_long_clips_are_looked_at_less_often(face, monkeypatch):
    looked = []
    seen = [(None, network_sees(IMAGE))] if face else []
    monkeypatch.setattr(mouth_check, "faces_seen", lambda _image: looked.append(1) or seen)
    check, found = MouthCheck(setting(rate=10.0)), result()
    for k in range(1000):
        check.add(IMAGE, replace(found, index=k))
    assert 4 * DOUBTS.looks < len(looked) < 8 * DOUBTS.looks


def test_the_warning_is_in_the_summary_of_a_run():
    recorder = Recorder(setting())
    recorder.add(result(0, right=40.0), IMAGE)
    assert any("it is drawn elsewhere" in w for w in recorder.record().summary["warnings"])
    unseen = Recorder(setting())
    unseen.add(result(0, right=40.0))
    assert not any("it is drawn elsewhere" in w for w in unseen.record().summary["warnings"])
