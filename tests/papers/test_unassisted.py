"""Sentences with less given: what is filmed, how lips are scored, what the report shows."""

from __future__ import annotations

import os
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from abs_engine.core.errors import CalibrationError, FaceNotFoundError
from abs_engine.face.talking_file import save_talking
from abs_engine.io.assets import load_speaker
from abs_engine.learn.spoken import bite_plane_of
from abs_engine.learn.training import checksum
from abs_engine.papers.odisio2004 import unassisted as room
from abs_engine.papers.odisio2004 import unassisted_faces as faces_room
from abs_engine.papers.odisio2004.filmed import SIZE
from abs_engine.papers.odisio2004.gathered import FULL, QUICK, Report
from abs_engine.papers.odisio2004.page import reproduction_page
from abs_engine.papers.odisio2004.reproduce import FACE, FILMED
from abs_engine.papers.odisio2004.sentences_filmed import plan_sentence
from abs_engine.papers.odisio2004.sentences_parts import unassisted_part
from abs_engine.papers.odisio2004.unassisted_faces import KnownFace, faces_of
from abs_engine.papers.odisio2004.visemes import film_speech
from abs_engine.papers.results import MISSING
from abs_engine.render.cpu import CpuRenderer
from abs_engine.studio.french import SENTENCES

FRAMES = 4


class Film(list):
    """A filmed sentence of which only its length counts."""

    camera, video = None, ""

    def __init__(self, heads=None):
        super().__init__(range(FRAMES))
        self.heads = heads

    def vertices(self, t):
        return self.heads[t]

    def pictures(self):
        return iter(["picture"] * FRAMES)


@pytest.fixture(scope="module")
def speaker():
    return load_speaker()


def report(folder, speaker, amount=FULL):
    return Report(folder, folder, CpuRenderer(), speaker, 0, print, "clara", False, amount)


def test_the_other_test_has_another_camera_light_and_motion(speaker):
    same, other = (
        plan_sentence(
            speaker, "clara", SENTENCES[0], filming.camera, 0,
            look=filming.look, reach=filming.reach,
        )
        for filming in (room.FILMINGS[room.SAME], room.FILMINGS[room.OTHER])
    )  # fmt: skip
    np.testing.assert_array_equal(same.weights, other.weights)
    turned, further = (
        max(plan.pose(plan.views[0], k).angle_to(plan.pose(plan.views[0], 0)) for k in range(9))
        for plan in (same, other)
    )
    assert further / turned == pytest.approx(1.7, rel=0.1)
    assert same.views[0].camera.size != other.views[0].camera.size
    assert not np.allclose(same.lights[0], other.lights[0])


class Rigid:
    """A shape whose only parameter moves the whole head along y, by mm."""

    neutral = np.zeros(1)

    def __init__(self, head, frame):
        self.frame, self.scene = frame, self
        self._head = head

    def vertices(self, row):
        return self._head + np.array([1.0, row[0], 0.0])  # and it is off by 1 mm


def tracked(monkeypatch, speaker, heads, **replaced):
    """The room with a rigid face, and a film of these heads; and what it is tracked with."""
    shape = Rigid(speaker.named("clara"), bite_plane_of(speaker, speaker.named("clara")))
    talker, asked = SimpleNamespace(shape=shape, face="looks"), []

    def track(face, model, pictures, camera, pose, *more, kept=None):
        asked.append((face, model, pose))
        return SimpleNamespace(alpha=np.array([[0.0], [0.0], [6.0], [6.0]]))

    rooms = {
        "load_truth": lambda _: Film(heads), "load_talking": lambda _: talker, "track": track,
        "pose_by_landmarks": lambda *_: "estimated", **replaced,
    }  # fmt: skip
    for name, value in rooms.items():
        monkeypatch.setattr(room, name, value)
    return asked


def scored(speaker, folder, face):
    tracker = room._Tracker(report(folder, speaker), KnownFace(face, None), "la_lin", None)
    one = tracker.score(folder / "film", folder / "kept")
    return room._pooled([one, one])


def test_lips_are_scored_in_the_frame_of_the_teeth(tmp_path, speaker, monkeypatch):
    """Found off by 1 mm all along; the lips move by 6 mm."""
    heads = np.repeat(speaker.named("clara")[None].astype(np.float64), FRAMES, axis=0)
    heads[FRAMES // 2 :, :, 1] += 6.0
    asked = tracked(monkeypatch, speaker, heads)
    row = scored(speaker, tmp_path, tmp_path / "a.face")
    assert asked == [("looks", "la_lin", "estimated")]
    assert (row["sentences"], row["frames"], row["found"]) == (2, 2 * FRAMES, 2)
    assert row["lips_mm"] == pytest.approx(1.0, rel=1e-6)
    assert row["lips_less_constant_mm"] == pytest.approx(0.0, abs=1e-6)
    assert row["motion_mm"] == pytest.approx(3.0, rel=1e-6)  # about its mean


def test_what_is_not_found_has_no_error(tmp_path, speaker, monkeypatch):
    def lost(*_, **__):
        raise FaceNotFoundError("no face is found", "film one")

    heads = np.repeat(speaker.named("clara")[None], FRAMES, axis=0)
    tracked(monkeypatch, speaker, heads, pose_by_landmarks=lost)
    for face in (None, tmp_path / "a.face"):
        row = scored(speaker, tmp_path, face)
        assert (row["frames"], row["found"]) == (2 * FRAMES, 0)
        assert row["lips_mm"] is row["lips_less_constant_mm"] is row["motion_mm"] is None
    assert MISSING in reproduction_page({"unassisted": [row]}, [])


def test_the_page_has_a_row_for_each_face_and_test():
    row = {"face": "measured", "test": "otherwise", "frames": 612, "lips_mm": 1.2345}
    text = reproduction_page({"unassisted": [row]}, [])
    assert "<td>measured</td><td>otherwise</td><td>612</td><td>1.23</td>" in text.replace("\n", "")


def test_the_quick_report_leaves_it_out(tmp_path, speaker):
    own = report(tmp_path, speaker, QUICK)
    unassisted_part(own, None)
    assert "unassisted" not in own.results


def test_a_session_in_which_nothing_can_be_observed_makes_no_face(tmp_path, speaker, monkeypatch):
    """The other faces are made all the same, and each has the postures of its own points."""

    def blind(*_):
        raise CalibrationError("the board was found in 0 pictures", "show it")

    built = SimpleNamespace(alpha=np.ones((2, 7)))
    monkeypatch.setattr(faces_room, "tracked_corpus", blind)
    monkeypatch.setattr(faces_room, "_write", lambda *_: None)
    bare = SimpleNamespace(built=built, spoken=None, person="clara")
    faces = faces_of(report(tmp_path, speaker), bare, tmp_path)
    assert [face.path is None for face in faces.values()] == [False, False, True]
    assert list(faces) == ["given", "measured", "tracked beads"]

    other = SimpleNamespace(alpha=np.zeros((2, 7)))
    monkeypatch.setattr(faces_room, "tracked_corpus", lambda *_: None)
    monkeypatch.setattr(faces_room, "build", lambda *_, **__: other)
    faces = faces_of(report(tmp_path, speaker), bare, tmp_path)
    assert faces["tracked beads"].postures is other.alpha
    assert faces["measured"].postures is built.alpha


@pytest.mark.skipif(
    not os.environ.get("ABS_ENGINE_SLOW"),
    reason="ten minutes of filming and tracking; ABS_ENGINE_SLOW=1 runs it",
)
def test_a_measured_face_follows_lips_about_as_well_as_the_true_head(tmp_path, speaker):
    own = report(tmp_path, speaker, replace(FULL, unassisted=1, frames=36))
    (tmp_path / FILMED).mkdir()
    speech = film_speech(speaker, "clara", tmp_path / FILMED / "bare", beads=0, size=SIZE, seed=0)
    save_talking(
        tmp_path / FACE, speech.learn(range(len(speech.pictures)), own.renderer), "clara",
        checksum(speaker),
    )  # fmt: skip
    unassisted_part(own, None)
    rows = {(row["face"], row["test"], row["model"]): row for row in own.results["unassisted"]}
    assert len(rows) == 12
    for row in rows.values():
        assert (row["found"], row["frames"]) == (1, 36)
        if row["model"] == "la_lin":
            assert row["lips_mm"] < 0.6 * row["motion_mm"]
    for name in ("measured", "tracked beads"):
        assert list(tmp_path.glob(f"unassisted-*/{name}.face"))
