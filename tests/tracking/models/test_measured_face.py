"""Faces of measured points: where their pictures show the head, and what they are refused."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from drawn import CAMERA, correspondence, lit, speaker, turned_by, vertices_of
from heads import seen_at
from talkers import CAMERA as BALL
from talkers import POSE, RENDERER, learned_face

from abs_engine.capture.viseme_pictures import VisemePicture
from abs_engine.core.errors import FaceNotFoundError, ParameterError, PictureError
from abs_engine.core.geometry import Pose
from abs_engine.core.scene import Candidates
from abs_engine.face.appearance.visibility import Sighting
from abs_engine.face.talking_file import save_talking
from abs_engine.tracking.models.measured_looks import (
    _camera,
    _sighting,
    by_texture,
    pose_by_landmarks,
)
from abs_engine.tracking.models.talking_faces import found_talker
from abs_engine.tracking.options import ClipTracker, Leaves, TrackOptions

PICTURE = Path("a.png")


def test_the_head_of_a_viseme_is_found_in_its_picture():
    pose, posture = seen_at([0.05, 0.15, 0.03], [10, -5, 650]), {"jawOpen": 0.4}
    image = lit("clara", pose, **posture)
    found = pose_by_landmarks(
        image, vertices_of("clara", **posture), speaker(), correspondence(), CAMERA, PICTURE
    )
    middle = vertices_of("clara")[speaker().lip_ring].mean(axis=0)
    assert turned_by(found, pose) < 4  # degrees
    away = found.apply(middle) - pose.apply(middle)
    assert abs(away[:2]).max() < 3
    assert abs(away[2]) < 25


def test_a_pose_is_found_again_by_the_texture():
    face, row = learned_face(), np.array([0.4, -0.3])
    rgb = RENDERER.draw(face.shape.scene, Candidates.one(row, POSE), BALL, BALL.whole)[0].rgb
    off = Pose(POSE.rotation, np.add(POSE.translation, [2.0, -1.5, 0.0]))
    vertices = face.shape.scene.vertices(row)
    found = by_texture(face, Sighting(rgb, vertices, off, row), BALL, RENDERER)
    before, after = (
        np.linalg.norm((p.translation - POSE.translation)[:2]) for p in (off, found.pose)
    )
    assert after < 0.4 * before
    np.testing.assert_array_equal(found.parameters, row)


def test_a_picture_without_a_face_is_named():
    blank = lit("clara")[:1].repeat(CAMERA.size[1], axis=0)
    with pytest.raises(FaceNotFoundError, match=r"no face is found in a\.png"):
        pose_by_landmarks(blank, speaker().vertices, speaker(), correspondence(), CAMERA, PICTURE)


def sighted(image, given):
    """A picture of Clara, and the pose that a table gives for it."""
    still, ahead = vertices_of("clara"), Pose(np.eye(3), np.zeros(3))
    shape = SimpleNamespace(scene=SimpleNamespace(vertices=lambda alpha: still), frame=ahead)
    made = SimpleNamespace(shape=shape, head=SimpleNamespace(speaker=speaker()))
    built = SimpleNamespace(alpha=[np.zeros(0)], corpus=SimpleNamespace(visemes=["a"]))
    one = VisemePicture(PICTURE, "a", given)
    return _sighting(made, built, one, image, CAMERA, correspondence())


TRUE = seen_at([0.05, 0.15, 0.03], [10, -5, 650])


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (
            Pose(TRUE.rotation, np.add(TRUE.translation, [40, 0, 0])),
            r"lies 4. mm from where a\.png shows",
        ),
        (Pose(TRUE.rotation, TRUE.translation / 10), r"the face is not in a\.png; give"),
        (Pose(TRUE.rotation.T, -TRUE.translation @ TRUE.rotation), r"lies .* mm from where a\.png"),
    ],
)
def test_a_pose_that_lies_far_from_the_picture_s_face_is_refused(given, said):
    with pytest.raises(ParameterError, match=said):
        sighted(lit("clara", TRUE), given)


def test_a_pose_that_is_right_or_cannot_be_compared_is_taken_as_it_is():
    blank = lit("clara")[:1].repeat(CAMERA.size[1], axis=0)
    near = Pose(TRUE.rotation, np.add(TRUE.translation, [4, 4, 20]))
    for image, given in ((lit("clara", TRUE), near), (blank, near)):
        assert sighted(image, given).pose.translation.tolist() == given.translation.tolist()
    with pytest.raises(ParameterError, match=r"the face is not in a\.png"):
        sighted(blank, Pose(TRUE.rotation, np.add(TRUE.translation, [400, 0, 0])))


def test_pictures_are_of_one_size():
    image, table = lit("clara"), [SimpleNamespace(path=PICTURE)] * 2
    with pytest.raises(PictureError, match=r"a\.png is"):
        _camera(table, [image, image[:-2]], None)


@pytest.mark.parametrize("term", ["texture", "local"])
def test_a_face_without_pictures_is_refused_what_needs_one(tmp_path, term):
    path = tmp_path / "me.face"
    save_talking(path, learned_face().shape, "me", "")
    options = TrackOptions(model_file=path, terms=(term,), driver="simplex")
    with pytest.raises(ParameterError, match=f"made without pictures and has no {term}"):
        found_talker(None, options, Leaves.of(options), RENDERER, print)


@dataclass(frozen=True)
class Setting:
    """What stands in for a clip's setting."""

    landmarks: str


def test_a_run_of_a_face_of_points_says_that_it_has_no_choice_of_evidence(tmp_path, monkeypatch):
    path = tmp_path / "me.face"
    save_talking(path, learned_face().shape, "me", "")
    made = ClipTracker(
        path, None, Setting("the network's"), None, facts={"start": "landmarks", "evidence": "both"}
    )
    where = "abs_engine.tracking.models.talking_faces"
    monkeypatch.setattr(f"{where}._own_head", lambda *_: "another head")
    monkeypatch.setattr(f"{where}.correspondence_of", lambda *_: None)
    monkeypatch.setattr(f"{where}.by_landmarks", lambda *_: made)
    options = TrackOptions(model_file=path, terms=("colour",), driver="simplex")
    base = found_talker(None, options, Leaves.of(options), RENDERER, print).base
    assert base.setting.landmarks is None
    assert base.facts == {"start": "landmarks", "evidence": None}
