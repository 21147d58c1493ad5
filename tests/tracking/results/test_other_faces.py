"""Faces besides the followed one are noticed: a larger one, or one where it is not found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from drawn import drawn
from heads import seen_at
from runs import lost_result, toy_result, toy_setting

from abs_engine.core.camera import Camera
from abs_engine.core.geometry import Pose
from abs_engine.tracking.detection.face_detection import find_faces
from abs_engine.tracking.results import other_faces
from abs_engine.tracking.results.other_faces import OtherFaces
from abs_engine.tracking.runs.recorder import Recorder
from abs_engine.tracking.settings.doubts import DOUBTS

NEAR, FAR = seen_at([0, 0, 0], [0, 0, 500]), seen_at([0, 0, 0], [0, 0, 1200])
ALONE = drawn("clara", NEAR)
CAMERA = Camera.ideal((ALONE.shape[1], ALONE.shape[0]))
BLANK = np.full_like(ALONE, 90)
BESIDE = np.hstack([BLANK, ALONE])
WIDE = Camera(CAMERA.matrix, (BESIDE.shape[1], BESIDE.shape[0]))


def setting(camera=WIDE, **changes):
    return replace(toy_setting(), camera=camera, rate=2.5, others=True, **changes)


def followed(index, pose):
    """The lips of a head whose pose is followed."""
    return replace(toy_result(index), pose=pose)


def warned(results, image, made=None):
    others = OtherFaces(made or setting())
    for one in results:
        others.add(image, one)
    return others.warnings()


def test_a_larger_face_beside_the_followed_one_is_reported_with_its_place():
    (line,) = warned([followed(k, FAR) for k in range(4)], BESIDE)
    assert line.startswith("a larger face than the one that is followed is seen in 4 of 4 frames")
    assert "first in frame 0 about" in line
    x = int(line.split("about ")[1].split()[0])
    assert ALONE.shape[1] < x < BESIDE.shape[1]


def test_the_followed_face_is_none_beside_itself_however_large_it_is_seen():
    drawn_small = Pose(NEAR.rotation, 2.0 * NEAR.translation)  # where it is, but farther away
    assert warned([followed(k, NEAR) for k in range(4)], ALONE, setting(CAMERA)) == []
    assert warned([followed(k, drawn_small) for k in range(4)], ALONE, setting(CAMERA)) == []


def test_one_that_passes_is_not_reported():
    others = OtherFaces(setting())
    for k in range(12):
        others.add(BESIDE if k in (4, 5) else np.hstack([BLANK, BLANK]), followed(k, FAR))
    assert others.warnings() == []


def test_another_face_where_the_followed_one_is_not_found():
    lost = [lost_result(k) for k in range(3)]
    (line,) = warned(lost, BESIDE)
    assert "another is seen: in 3 of 3 frames that were looked at" in line
    assert warned(lost, np.hstack([BLANK, BLANK])) == []
    assert warned(lost[:1], BESIDE) == []


def test_where_a_user_has_chosen_none_is_looked_for(monkeypatch):
    monkeypatch.setattr(other_faces, "find_faces", lambda *_, **__: pytest.fail("it was asked"))
    made = replace(setting(), others=False)
    assert warned([followed(k, FAR) for k in range(4)], BESIDE, made) == []


def test_long_clips_are_looked_at_less_often(monkeypatch):
    looked = []
    monkeypatch.setattr(other_faces, "find_faces", lambda *_, **__: looked.append(1) or [])
    warned([followed(k, FAR) for k in range(1000)], BLANK)
    assert 4 * DOUBTS.looks < len(looked) < 8 * DOUBTS.looks


@pytest.mark.parametrize(("frames", "warned"), [(range(1000, 2000), True), (range(100), False)])
def test_a_look_counts_as_many_frames_as_lie_before_the_next(frames, warned, monkeypatch):
    (face,) = find_faces(BESIDE)
    monkeypatch.setattr(other_faces, "find_faces", lambda image, **_: [face] if image.any() else [])
    others, seen = OtherFaces(setting()), np.ones((1, 1, 3), np.uint8)
    for k in range(2000):
        others.add(seen if k in frames else 0 * seen, followed(k, FAR))
    assert bool(others.warnings()) is warned


def test_the_warning_is_in_the_summary_of_a_run():
    recorder = Recorder(setting())
    for k in range(3):
        recorder.add(followed(k, FAR), BESIDE)
    assert any("a larger face than the one" in w for w in recorder.record().summary["warnings"])
