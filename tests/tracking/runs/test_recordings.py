"""Which recordings a speaker's face can be learned from, and which of their frames."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from runs import (
    lost_result,
    noise,
    rewrite,
    toy_result,
    toy_setting,
    write_kind,
    write_noise,
    written_run,
)

from abs_engine.cli import main
from abs_engine.core.camera import Camera
from abs_engine.core.errors import (
    FaceNotFoundError,
    InputFileError,
    ModelFormatError,
    OtherPersonError,
    ParameterError,
    TooFewFramesError,
)
from abs_engine.dataset.camera_file import camera_json
from abs_engine.dataset.sums import check_distinct
from abs_engine.face.head import build_mouth_model
from abs_engine.io.assets import load_speaker
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.detection.face_choice import FOLLOWS, LARGEST, FaceChoice
from abs_engine.tracking.detection.initial_pose import FaceBox
from abs_engine.tracking.detection.shot_cuts import cut_line
from abs_engine.tracking.options import TrackOptions
from abs_engine.tracking.person.scale import USUAL_PUPILS, Scale
from abs_engine.tracking.runs.recordings import (
    Recording,
    check_variety,
    check_videos,
    load_recording,
    mouth_box,
)
from abs_engine.tracking.runs.same_person import check_same, doubt_same
from abs_engine.tracking.settings.frames import FRAME_LOOP
from abs_engine.tracking.speaker import speaker_learning
from abs_engine.tracking.speaker.recorded_frames import camera_used
from abs_engine.tracking.speaker.speaker_learning import Learned, Learner, learn_speaker
from abs_engine.tracking.speaker.speakers import SpeakerClip

FRAMES = 50
CAMERA = Camera.ideal((96, 80))


def recording(name="one.mp4", aperture=None, widened=0.0, larger=1.0):
    """A recording of the bundled head, made so much wider, and larger by its pupils' distance."""
    aperture = np.linspace(0, 12, FRAMES) if aperture is None else aperture
    count = len(aperture)
    no = np.zeros(count, np.bool_)
    arrays = {
        "index": np.arange(count), "found": ~no, "covered": no, "contradicted": no,
        "status": np.full(count, "converged"), "aperture": aperture,
        "width": np.linspace(50, 40, count), "rate": np.array(25.0),
        "camera_matrix": CAMERA.matrix, "camera_distortion": CAMERA.distortion,
        "camera_size": np.array(CAMERA.size),
    }  # fmt: skip
    head = load_speaker().vertices * np.array([1 + widened, 1, 1], np.float32) * larger
    return Recording(
        Path(name), Path("film.mp4"), arrays, head, np.zeros((count, 3)), larger * USUAL_PUPILS
    )


def test_the_end_and_what_is_doubted_are_not_learned_from():
    one = recording()
    one.run["covered"][3] = one.run["contradicted"][4] = True
    one.run["found"][5], one.run["status"][6] = False, "not converged"
    assert np.flatnonzero(~one.usable).tolist() == [3, 4, 5, 6, *range(40, 50)]


def test_frames_are_spread_over_postures():
    """Of a long rest and a short opening, frames of both are taken."""
    one = recording(aperture=np.r_[np.zeros(40), np.linspace(1, 9, 10), np.zeros(20)])
    chosen = one.spread(8)
    assert len(chosen) == len(set(chosen)) == 8
    assert one.usable[chosen].all()
    assert {0.0, 9.0} <= set(one.run["aperture"][chosen])


@pytest.mark.parametrize(
    ("aperture", "lacks"),
    [
        (np.zeros(FRAMES), "no open mouth in 40 frames that can be learned from; give longer"),
        (np.full(FRAMES, 8.0), "no closed mouth"),
        (np.zeros(1), "in 1 frame that"),
    ],
)
def test_too_little_variety_is_said(aperture, lacks):
    with pytest.raises(TooFewFramesError, match=lacks):
        check_variety([recording(aperture=aperture)])


def test_variety_is_that_of_all_recordings_together():
    check_variety([recording(aperture=np.zeros(FRAMES)), recording(aperture=np.full(FRAMES, 8.0))])


def test_the_recording_of_another_person_is_named():
    same = [recording(f"{k}.mp4", widened=0.002 * k) for k in range(4)]
    check_same(same, load_speaker())
    with pytest.raises(OtherPersonError, match=r"stranger\.mp4 does not show the same person"):
        check_same([*same, recording("stranger.mp4", widened=0.1)], load_speaker())
    with pytest.raises(OtherPersonError, match=r"0\.mp4 and stranger\.mp4"):
        check_same([same[0], recording("stranger.mp4", widened=0.1)], load_speaker())


def test_a_face_of_another_shape_is_doubted():
    """Wider, by less than is refused, as people who smile are; not only higher or deeper."""
    same = [recording(f"{k}.mp4", widened=0.002 * k) for k in range(4)]
    wide = recording("stranger.mp4", widened=0.04)
    speaker = load_speaker()
    assert doubt_same(same, speaker) is doubt_same(same[:1], speaker) is None
    check_same([*same, wide], speaker)
    number, said = doubt_same([*same, wide], speaker)
    assert number == 4
    assert "warning: may not show the same person as the others: the shape of" in said
    assert "same person as 0.mp4:" in doubt_same([same[0], wide], speaker)[1]
    high = replace(same[0], head=same[0].head * np.array([1, 1.02, 0.98], np.float32))
    assert doubt_same([same[0], high], speaker) is None


def test_speaker_warns_of_a_recording_that_it_doubts(tmp_path, capsys, monkeypatch):
    folders = [tmp_path / name for name in ("own", "again", "stranger")]
    for folder in folders:
        folder.mkdir()
    made = {one: recording(one, widened=0.04 * (one.name == "stranger")) for one in folders}
    made[folders[1]] = replace(made[folders[1]], remarks=("two shots",))
    where = "abs_engine.tracking.runs.recordings"
    monkeypatch.setattr(f"{where}.load_recording", lambda path, _: made[path])
    monkeypatch.setattr(f"{where}.check_videos", lambda _: (96, 80))
    monkeypatch.setattr("abs_engine.tracking.speaker.recorded_frames.check_colours", lambda _: None)
    words = ["speaker", *map(str, folders), "-o", str(tmp_path / "me.face")]
    assert main([*words, "--renderer", "cpu"]) == 2  # there is no film to learn from
    said = "".join(capsys.readouterr())
    assert "again: two shots" in said
    assert "stranger: warning: may not show the same person as the oth" in said
    assert re.search(r"warning: 3 recordings of \d+ s in all; 5 recordings of 3 s are", said)


def test_heads_are_compared_in_one_size():
    check_same([recording("a.mp4"), recording("b.mp4", larger=1.26)], load_speaker())


def test_heads_are_compared_without_the_mean_posture_of_what_tracked_them():
    """In another posture, as of other physics; where one does not say its rest, in that posture."""
    speaker, closed = load_speaker(), recording("a.mp4")
    parted = replace(recording("b.mp4", widened=0.1), rest=closed.head)
    check_same([replace(closed, rest=closed.head), parted], speaker)
    with pytest.raises(OtherPersonError):
        check_same([closed, parted], speaker)


def test_a_video_that_comes_twice_is_refused(tmp_path):
    one, other, run = tmp_path / "one.mp4", tmp_path / "other.mp4", tmp_path / "run"
    one.write_bytes(b"pictures")
    other.write_bytes(b"others")
    check_distinct([(one, one), (run, other)])
    with pytest.raises(ParameterError, match=r"one\.mp4 and .*run come from the same video"):
        check_distinct([(one, one), (other, other), (run, one)])


def test_speaker_refuses_a_video_that_is_typed_twice(tmp_path, capsys):
    one, other = (write_kind(tmp_path / f"{n}.mp4", "libx264", noise(2, seed=n)) for n in (1, 2))
    out = tmp_path / "me.face"
    assert main(["speaker", *map(str, (one, one, other)), "-o", str(out)]) == 2
    assert f"{one} and {one} come from the same video; give it once" in capsys.readouterr().err
    assert not out.exists()


def test_videos_of_one_size_are_asked_for(tmp_path):
    small, large = (
        write_kind(tmp_path / f"{name}.mp4", "libx264", noise(2, size, seed))
        for seed, (name, size) in enumerate([("a", (96, 80)), ("b", (128, 96))])
    )
    assert check_videos([(small, small)]) == (96, 80)
    with pytest.raises(ParameterError, match=r"run has 128x96 pixels, .*a\.mp4 96x80"):
        check_videos([(small, small), (tmp_path / "run", large)])
    with pytest.raises(ParameterError, match="come from the same video"):
        check_videos([(small, small), (tmp_path / "run", small)])


@pytest.fixture
def run(tmp_path):
    """A run of a video that lies elsewhere."""
    run = written_run(tmp_path / "run", [0, 1])
    (tmp_path / "elsewhere").mkdir()
    video = write_noise(tmp_path / "elsewhere" / "talk.mp4")
    summary = json.loads((run / "run.json").read_text())
    named = {"video": video.name, "video_sha256": sha256(video.read_bytes()).hexdigest()}
    summary["settings"] = {
        **named, "video_path": "../elsewhere/talk.mp4", "scale": {"pupils": 60.0}
    }  # fmt: skip
    (run / "run.json").write_text(json.dumps(summary))
    return run


def test_its_video_is_taken_from_where_the_run_says_that_it_was(run, tmp_path):
    video = tmp_path / "elsewhere" / "talk.mp4"
    found = load_recording(run, load_speaker())
    assert found.video.samefile(video)
    assert (found.path, found.pupils) == (run, 60.0)
    np.testing.assert_array_equal(found.rest, toy_setting().face.body.rest)
    video.rename(tmp_path / "talk.mp4")
    assert load_recording(run, load_speaker()).video.samefile(tmp_path / "talk.mp4")
    with (tmp_path / "talk.mp4").open("ab") as file:
        file.write(b"more")
    with pytest.raises(InputFileError, match="has changed since it was tracked"):
        load_recording(run, load_speaker())
    (tmp_path / "talk.mp4").unlink()
    with pytest.raises(InputFileError, match="is not there"):
        load_recording(run, load_speaker())


def chosen(run, **settings):
    """The face of a run whose settings are changed so."""
    path = run / "run.json"
    summary = json.loads(path.read_text())
    summary["settings"] |= settings
    path.write_text(json.dumps(summary))
    return load_recording(run, load_speaker()).choice


def test_a_run_keeps_the_face_that_was_tracked(run):
    box = (10.0, 20.0, 30.0, 15.0)
    assert chosen(run) == LARGEST
    assert chosen(run, face=2, mouth=None) == FaceChoice(2)
    assert chosen(run, face=None, mouth=box) == FaceChoice(box=FaceBox.around_mouth(*box))
    placed = chosen(run, mouth=None, poses="poses.csv").box
    lips = toy_setting().camera.project(toy_result(0).pose.apply(toy_result(0).lips))
    np.testing.assert_allclose(placed.mouth[0], lips[:, 0].min() + np.ptp(lips[:, 0]) / 2)


@pytest.mark.parametrize("wrong", [{"face": 0}, {"face": "left"}, {"mouth": [1, 2]}, {"mouth": 3}])
def test_a_run_that_names_no_face_is_refused(run, wrong):
    with pytest.raises(ModelFormatError, match="does not state its video, its face or its scale"):
        chosen(run, **wrong)


def test_later_frames_have_the_face_where_it_was_tracked(run):
    whole = load_recording(run, load_speaker())
    assert whole.choice_from(1) == LARGEST
    second = replace(whole, choice=FaceChoice(2))
    assert second.choice_from(0) == FaceChoice(2)
    assert second.choice_from(1).box == mouth_box(whole.run, 1) is not None
    lost = replace(second, run=second.run | {"found": np.zeros(2, np.bool_)})
    assert lost.choice_from(1) == FaceChoice(2)


def test_a_recording_that_is_tracked_again_keeps_its_face(monkeypatch):
    """The second person's: the face that is learned had been a mixture with the larger one."""
    asked = []

    class Followed(SpeakerClip):
        def tracker(self, *_):
            asked.append(self.choice)
            return SimpleNamespace(setting=toy_setting())

    monkeypatch.setattr(speaker_learning, "SpeakerClip", Followed)
    monkeypatch.setattr(speaker_learning, "probe", lambda _: None)
    monkeypatch.setattr(speaker_learning, "read_frames", lambda _: ())
    monkeypatch.setattr(speaker_learning, "track", lambda *_: (one for one in ()))
    one, learner = replace(recording(), choice=FaceChoice(2)), Learner(*[None] * 5)
    record = learner.followed(one, None)
    assert asked == [FaceChoice(2)]
    assert one.again(record, Scale("usual", 63.4, 0.06)).choice == FaceChoice(2)


def test_what_is_said_of_a_video_comes_with_its_recording(monkeypatch, tmp_path):
    """Several faces, and a doubtful result: `speaker` had passed over both."""
    results = ((None, replace(lost_result(index), cut=index == 2)) for index in range(3))
    said = (
        f"the video is marked as interlaced\n2 faces: 1 here; 2 there; {FOLLOWS}\n{cut_line([2])}"
    )
    tracker = SimpleNamespace(
        remarks=said, setting=toy_setting(), scale=Scale("usual", 63.4, 0.06),
        results=lambda: results,
    )  # fmt: skip
    monkeypatch.setattr(speaker_learning, "prepare", lambda *_: tracker)
    one = speaker_learning.tracked(tmp_path, None, TrackOptions())
    faces, shots, interlaced, warning = one.remarks
    assert shots.startswith("warning: another shot begins with frame 2: one face is learned")
    assert faces.endswith("'track --face N' follows another: give its run in place of the video")
    assert "interlaced" in interlaced
    assert warning.startswith("warning: no frame was tracked (face not found in 3)")


def test_a_run_with_several_shots_is_warned_of(run):
    assert load_recording(run, load_speaker()).remarks == ()
    rewrite(run, cut=np.array([False, True]))
    (said,) = load_recording(run, load_speaker()).remarks
    assert said.startswith("warning: another shot begins with frame 1: one face")


def test_a_run_of_another_head_is_refused(run):
    other = replace(load_speaker(), faces=load_speaker().faces[:, ::-1])
    with pytest.raises(ModelFormatError, match="tracked with another head"):
        load_recording(run, other)


@pytest.mark.parametrize("lacking", ["covered", "contradicted", "rate"])
def test_a_run_of_an_earlier_version_is_refused(run, lacking):
    rewrite(run, lacking)
    with pytest.raises(ModelFormatError, match=rf"the run .*run lacks {lacking}; track it again"):
        load_recording(run, load_speaker())


def test_a_run_of_a_worn_camera_is_refused(run):
    with np.load(run / "results.npz") as data:
        values = np.zeros((len(data["found"]), 1))
    rewrite(run, term_names=np.array(["opening"]), term_values=values)
    with pytest.raises(InputFileError, match="run was tracked with --worn; give recordings"):
        load_recording(run, load_speaker())


def test_a_camera_of_another_picture_is_refused_before_anything_is_tracked(tmp_path, capsys):
    video, camera = write_noise(tmp_path / "talk.mp4"), tmp_path / "camera.json"
    camera.write_text(camera_json(Camera.ideal((96, 90))), encoding="utf-8")
    words = ["speaker", str(video), "-o", str(tmp_path / "me.face"), "--camera", str(camera)]
    assert main([*words, "--renderer", "cpu"]) == 2
    assert "the camera has 96x90 pixels, the video 96x80; give" in capsys.readouterr().err
    one = replace(recording(), path=video, video=video)
    with pytest.raises(ParameterError, match="the camera has 96x90 pixels"):
        learn_speaker([one], CpuRenderer(), TrackOptions(camera=Camera.ideal((96, 90))))


def test_a_run_by_another_camera_is_refused(run, tmp_path, capsys):
    words = ["speaker", str(run), "-o", str(tmp_path / "me.face"), "--renderer", "cpu"]
    assert main(words) == 2  # of a camera of 320x240 pixels
    assert "run was tracked with another camera than is used here" in capsys.readouterr().err
    given = Camera(CAMERA.matrix, CAMERA.size, np.array([0.1]))
    assert camera_used([recording()], None, CAMERA.size).distortion.max() == 0
    assert camera_used([], given, CAMERA.size) is given
    with pytest.raises(ParameterError, match=r"one\.mp4 was tracked with another camera"):
        camera_used([recording()], given, CAMERA.size)


def test_frames_left_out_that_show_no_face_count_as_unexplained(monkeypatch):
    """All that was learned had been lost with them."""

    def followed(_, one, face, first):
        if one.path.name == "away.mp4":
            raise FaceNotFoundError("no face was found", "give another video")
        return SimpleNamespace(arrays={"score": np.full(one.count - first, 0.9)})

    monkeypatch.setattr(Learner, "followed", followed)
    learner = Learner(*[None] * 4, lambda _: None)
    there, away = recording("there.mp4"), recording("away.mp4")
    assert learner.explained([there, away], None) == pytest.approx(0.45)


def test_a_folder_that_is_no_run_is_refused(tmp_path):
    with pytest.raises(InputFileError, match=str(tmp_path)):
        load_recording(tmp_path, load_speaker())


def test_a_face_is_not_learned_from_a_video_and_its_copy(tmp_path):
    one = write_noise(tmp_path / "one.mp4")
    other = tmp_path / "other.mp4"
    other.write_bytes(one.read_bytes())
    given = [replace(recording(), path=path, video=path) for path in (one, other)]
    with pytest.raises(ParameterError, match="come from the same video"):
        learn_speaker(given, CpuRenderer())


def test_of_too_few_frames_no_postures_are_learned_and_a_line_says_so():
    """Of two seconds, a smile was not followed, and closures after a shout were missed."""
    few = recording(aperture=np.linspace(0, 12, 249))
    assert few.usable.sum() == 199
    learner = Learner(*[None] * 5)
    assert learner.postures(None, [few]) is None
    face = SimpleNamespace(posture=SimpleNamespace(names=()), appearance=None)
    space = SimpleNamespace(own=False, left_out=(), expression=SimpleNamespace(variance=()))
    said = Learned(face, space, 199, (0.9,), 1).lines()
    assert said[0] == (
        "postures: generic, as only 199 frames show the mouth well; the speaker's own need 200"
    )
    assert said[1].endswith("left out: 90.0% in round 1; kept: round 1")
    told = Learned(face, space, 199, (0.95512, 0.9553), 2).lines()[1]
    assert told.endswith("left out: 95.51% in round 1, 95.53% in round 2; kept: round 2")
    same = Learned(face, space, 199, (0.9, 0.9), 1).lines()[1]
    assert "in round 2; kept: round 1" in same


def test_recordings_have_their_own_rates_and_single_frames_the_usual_steps():
    speaker = load_speaker()
    texture = speaker.texture(next(iter(speaker.people)))
    model = build_mouth_model(speaker, speaker.vertices, texture, free_person=False)
    learner, moved = Learner(speaker, *[None] * 4), np.zeros((2, len(model.expression.modes)))
    moved[0, 0] = moved[1, 1] = 1.0

    def said(rate: float, seconds: float = 8.0) -> Recording:
        time = np.arange(round(seconds * rate))[:, None] / rate
        smooth = np.sin(time * [11.0, 7.0] + [0, 1]) @ moved
        noisy = smooth + np.random.default_rng(0).normal(0, 0.02, smooth.shape)
        one = recording(aperture=np.zeros(len(time)))
        return replace(one, run={**one.run, "rate": np.array(rate)}, postures=noisy)

    slow, fast = said(25.0), said(50.0)
    both, turned = (learner.postures(model, r) for r in ([slow, fast], [fast, slow]))
    np.testing.assert_allclose(turned.steps[:2], both.steps[:2], rtol=1e-6)
    alone = said(25.0, 24.0)
    alone.run["covered"] = np.arange(alone.count) % 2 == 1
    usual = learner.postures(model, [alone]).steps
    np.testing.assert_array_equal(usual, np.full(len(usual), FRAME_LOOP.step_deviation))
