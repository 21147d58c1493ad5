"""A speaker's own face: learned from a recording, written, read, and tracked with."""

from __future__ import annotations

import contextlib
import json
from dataclasses import replace
from hashlib import sha256
from types import SimpleNamespace

import numpy as np
import pytest
from drawn import lit
from heads import seen_at
from runs import write_kind, write_noise

import abs_engine
from abs_engine.cli import main
from abs_engine.cli.commands.speaker import _few
from abs_engine.core.camera import Camera
from abs_engine.core.errors import ModelFormatError
from abs_engine.dataset.camera_file import camera_json
from abs_engine.face.learned_appearance import LocalLooks
from abs_engine.io.assets import load_speaker
from abs_engine.learn import posture_space
from abs_engine.learn.settings import LEARNING
from abs_engine.tracking.results.run_warnings import FACE_LOOKS, OTHER_COLOURS, UNCOVERED
from abs_engine.tracking.runs.record import load_run
from abs_engine.tracking.settings.doubts import DOUBTS
from abs_engine.tracking.settings.preparation import PREPARATION
from abs_engine.tracking.speaker import speaker_learning
from abs_engine.tracking.speaker.clip_looks import ANEW
from abs_engine.tracking.speaker.speaker_face import load_speaker_face
from abs_engine.tracking.start import shaded_skin

FRAMES, AGAIN = 20, 6
TIME = 1.2 * np.arange(FRAMES)
OPEN = np.clip(0.35 * np.sin(0.5 * TIME), 0, None)
NEAR = np.clip(0.3 * np.sin(1.2 * np.arange(AGAIN) - 0.5), 0, None)
ROUND = np.clip(0.8 * np.sin(0.35 * TIME + 1), 0, None)
pytestmark = pytest.mark.slow


def run(*words):
    """Exit status of the command."""
    return main([str(word) for word in words])


@pytest.fixture(scope="module")
def video(tmp_path_factory):
    """A drawn head that opens its mouth, rounds its lips and turns a little."""
    pictures = [
        lit("mei", seen_at([0, 0.1 * np.sin(0.3 * TIME[k]), 0], [0, 0, 700]), jawOpen=OPEN[k],
            mouthPucker=ROUND[k])
        for k in range(FRAMES)
    ]  # fmt: skip
    return write_kind(tmp_path_factory.mktemp("film") / "head.mp4", "libx264", pictures)


@pytest.fixture(scope="module")
def nearer(tmp_path_factory):
    """The same head in another movement, nearer to a camera of another size and focal length."""
    camera = Camera.ideal((400, 320), focal=560.0)
    pictures = [
        lit("mei", seen_at([0, -0.08 * np.cos(0.5 * k), 0], [5, 3, 520]), camera, jawOpen=NEAR[k])
        for k in range(AGAIN)
    ]
    folder = tmp_path_factory.mktemp("nearer")
    text = camera_json(camera)
    (folder / "camera.json").write_text(text, encoding="utf-8")
    return write_kind(folder / "near.mp4", "libx264", pictures)


def once(function):
    """The function, which gives its first result again: what all that is learned here begins with.

    What it is given is the same each time.
    """
    kept = []

    def call(*given):
        kept[:] = kept or [function(*given)]
        return kept[0]

    return call


def again(*given):
    """All recordings, tracked with one head."""
    return list(TRACKED_AGAIN(*given))


TRACKED_AGAIN = speaker_learning.Learner.tracked_again
TRACKED, HEAD = once(speaker_learning.tracked), once(speaker_learning.Learner.head)
AGAIN_TRACKED = once(again)


def learn(video, name, **settings):
    """The file of a face, learned from hardly a second, and what the command said."""
    path, said = video.with_name(f"{name}.face"), video.with_name(f"{name}.json")
    with pytest.MonkeyPatch.context() as patch, said.open("w") as file:
        patch.setattr(speaker_learning, "tracked", TRACKED)
        patch.setattr(speaker_learning.Learner, "head", HEAD)
        patch.setattr(speaker_learning.Learner, "tracked_again", AGAIN_TRACKED)
        few = replace(LEARNING, **({"least_frames": 6} | settings))
        for module in (posture_space, speaker_learning):
            patch.setattr(module, "LEARNING", few)
        patch.setattr(speaker_learning, "PREPARATION", replace(PREPARATION, speaker_most=6))
        with contextlib.redirect_stdout(file):
            words = "--renderer", "cpu", "--rounds", 1, "--quiet", "--json"
            assert run("speaker", video, "-o", path, *words) == 0
    return path, json.loads(said.read_text())


@pytest.fixture(scope="module")
def learned(video):
    """A face as it is learned by default."""
    return learn(video, "me")


@pytest.fixture
def refused(capsys, tmp_path):
    """The one line with which a command is refused, nothing written."""

    def words(*typed):
        before = sorted(tmp_path.rglob("*"))
        assert run(*typed, "--quiet", "--renderer", "cpu") == 2
        lines = capsys.readouterr().err.splitlines()
        assert len(lines) == 1, lines
        assert sorted(tmp_path.rglob("*")) == before
        return lines[0]

    return words


def test_what_is_learned_is_reported(learned):
    facts = learned[1]
    assert facts["postures"].keys() >= {"jaw1", "lips1"}
    assert facts["postures"]["jaw1"] > 0.5
    every = {predictor.name for predictor in posture_space.PREDICTORS}
    assert facts["postures"].keys() | set(facts["left_out"]) == every
    assert facts["round"] == 1
    assert 0.5 < facts["explained"][0] < 1


def test_anybodys_postures_are_kept_where_ones_own_explain_less(video, tmp_path):
    path, facts = learn(video, "anybody", worse=-1.0)
    assert facts["left_out"] == []
    assert set(facts["postures"]) == {f"shape{k + 1}" for k in range(len(facts["postures"]))}
    folder = tmp_path / "run"
    assert run("track", video, "-o", folder, "--renderer", "cpu", "--model", path) == 0
    assert np.corrcoef(load_run(folder)["aperture"], OPEN)[0, 1] > 0.95


def test_a_clip_is_tracked_with_it(learned, video, tmp_path):
    folder = tmp_path / "run"
    assert run("track", video, "-o", folder, "--renderer", "cpu", "--model", learned[0]) == 0
    found = load_run(folder)
    assert found["found"].all()
    assert np.corrcoef(found["aperture"], OPEN)[0, 1] > 0.95
    names = [str(name) for name in found["parameter_names"]]
    assert names[6:] == list(learned[1]["postures"])
    told = json.loads((folder / "run.json").read_text())
    named = told["settings"]
    assert named["model_sha256"] == sha256(learned[0].read_bytes()).hexdigest()
    assert named["colours"] == "the face's"
    assert named["terms"] == ["colour", "shading"]
    assert named["head_misfit"] < DOUBTS.most_speaker_misfit
    assert told["summary"]["warnings"] == []


def test_where_too_little_skin_is_seen_shading_is_left_out(learned, video, monkeypatch):
    monkeypatch.setattr(shaded_skin, "with_shading", lambda *_: None)
    plain = abs_engine.track(video, renderer="cpu", model=learned[0])
    assert plain.settings["terms"] == ["colour"]
    assert [line for line in plain.warnings if line.startswith("too little skin is seen")]
    assert plain.found.all()


def test_in_another_light_the_looks_are_learned_from_the_clip(learned, tmp_path):
    """By the colours of its recordings, its lips were missed in part."""
    lamp = np.array([1.2, 0.9, 0.6])
    pictures = [
        (lamp * lit("mei", seen_at([0, 0.05 * k, 0], [0, 0, 700]), jawOpen=NEAR[k]))
        .clip(0, 255)
        .astype(np.uint8)
        for k in range(AGAIN)
    ]
    film, folder = write_kind(tmp_path / "lamp.mp4", "libx264", pictures), tmp_path / "run"
    assert run("track", film, "-o", folder, "--renderer", "cpu", "--model", learned[0]) == 0
    told = json.loads((folder / "run.json").read_text())["settings"]
    assert (told["remarks"], told["colours"]) == (ANEW, "learned")
    assert told["terms"] == ["colour", "shading"]
    found = load_run(folder)
    assert np.corrcoef(found["aperture"], NEAR)[0, 1] > 0.95
    assert [str(name) for name in found["parameter_names"]][6:] == list(learned[1]["postures"])


@pytest.fixture(scope="module")
def other(tmp_path_factory):
    """Another person."""
    pictures = [lit("walter", seen_at([0, 0.02 * k, 0], [0, 0, 700])) for k in range(3)]
    return write_kind(tmp_path_factory.mktemp("other") / "other.mp4", "libx264", pictures)


def test_another_person_is_said_to_be_one(learned, other, tmp_path, capsys):
    """It had passed for the speaker, without a word."""
    typed = "track", other, "-o", tmp_path / "run", "--renderer", "cpu", "--model", learned[0]
    assert run(*typed) == 0
    (warning, *_) = json.loads((tmp_path / "run/run.json").read_text())["summary"]["warnings"]
    assert "is it the same speaker?" in warning
    assert warning in capsys.readouterr().out


def test_colours_are_not_advised_where_texture_is_compared(learned, other, tmp_path):
    """They are refused beside it."""
    typed = "track", other, "-o", tmp_path / "run", "--renderer", "cpu", "--model", learned[0]
    assert run(*typed, "--terms", "texture", "--driver", "axes") == 0
    told = json.loads((tmp_path / "run/run.json").read_text())["summary"]["warnings"]
    assert told[-1] == FACE_LOOKS


@pytest.mark.parametrize(
    ("chromatic", "said"),
    [
        (True, (UNCOVERED, "colours.npz")),
        (False, (OTHER_COLOURS.format("without"), "the face's")),
    ],
)
def test_a_line_says_what_comes_of_other_colours(learned, nearer, tmp_path, chromatic, said):
    """No mouth counts as covered in them; those of a video without colour are not used."""
    colours = tmp_path / "colours.npz"
    face = load_speaker_face(learned[0], load_speaker())
    replace(face.classes, chromatic=chromatic).save(colours)
    typed = "track", nearer, "-o", tmp_path / "run", "--renderer", "cpu", "--model", learned[0]
    assert run(*typed, "--camera", nearer.with_name("camera.json"), "--colours", colours) == 0
    told = json.loads((tmp_path / "run/run.json").read_text())["settings"]
    assert (told["remarks"], told["colours"]) == said


def test_the_file_comes_back(learned, tmp_path):
    face = load_speaker_face(learned[0], load_speaker())
    face.save(tmp_path / "again.face")
    again = load_speaker_face(tmp_path / "again.face", load_speaker())
    one, other = face.arrays(), again.arrays()
    assert one.keys() == other.keys()
    for name in one:
        np.testing.assert_array_equal(one[name], other[name], err_msg=name)


def test_appearance_is_learned(learned):
    own = load_speaker_face(learned[0], load_speaker()).appearance
    said = learned[1]["appearance"]
    assert said["texture"] == own.texture.explained > 0.05
    assert said["local"] == own.local.explained > 0.2
    assert said["points"] == len(own.local) > 20
    assert 0 < own.texture_noise < 0.05
    assert own.texture_observations > 0 < own.own_share <= 1
    assert 0.3 < own.per_mm <= 1


@pytest.mark.parametrize(
    "words",
    [
        ("colour+texture+local",),
        ("local", "--driver", "levenberg"),
        ("texture", "--driver", "axes"),
    ],
    ids=lambda words: "-".join(words),
)
def test_another_camera_and_distance_fit_by_appearance(learned, nearer, tmp_path, words):
    folder, camera = tmp_path / "run", nearer.with_name("camera.json")
    typed = "--renderer", "cpu", "--model", learned[0], "--camera", camera, "--terms", *words
    assert run("track", nearer, "-o", folder, *typed, "--quiet") == 0
    found = load_run(folder)
    assert found["found"].all()
    names = [str(name) for name in found["term_names"]]
    assert names == [*words[0].split("+"), "prior"]
    assert np.corrcoef(found["aperture"], NEAR)[0, 1] > 0.95
    shut, wide = found["aperture"][NEAR == 0], found["aperture"][NEAR > 0.2]
    assert shut.max() + 2 < wide.min()


def test_descriptors_keep_their_scale_in_millimetres(learned):
    own = load_speaker_face(learned[0], load_speaker()).appearance
    looks = LocalLooks(own.local, None, 1.0, own.per_mm)
    assert looks.scale_at(2.0) == pytest.approx(own.per_mm / 2)
    assert LocalLooks(own.local, None, 0.7).scale_at(2.0) == 0.7


def test_a_file_without_a_part_is_refused(learned, tmp_path):
    with np.load(learned[0]) as data:
        left = {name: data[name] for name in data.files if name != "steps"}
    with (tmp_path / "less.face").open("wb") as file:
        np.savez(file, **left)
    with pytest.raises(ModelFormatError):
        load_speaker_face(tmp_path / "less.face", load_speaker())


def test_what_a_speakers_face_cannot_do_is_refused(learned, video, refused, tmp_path):
    typed = "track", video, "-o", tmp_path / "run", "--model", learned[0]
    assert "--pupil-distance does nothing" in refused(*typed, "--pupil-distance", 60)
    assert "needs residuals" in refused(*typed, "--terms", "colour+local", "--driver", "levenberg")


def test_appearance_in_the_light_of_other_colours_is_refused(learned, video, refused, tmp_path):
    colours = tmp_path / "colours.npz"
    load_speaker_face(learned[0], load_speaker()).classes.save(colours)
    typed = "track", video, "-o", tmp_path / "run", "--model", learned[0], "--colours", colours
    assert "texture is compared in the light" in refused(*typed, "--terms", "texture")


def test_a_face_without_appearance_tracks_by_colour_alone(learned, video, refused, tmp_path):
    bare = replace(load_speaker_face(learned[0], load_speaker()), appearance=None)
    bare.save(tmp_path / "bare.face")
    assert load_speaker_face(tmp_path / "bare.face", load_speaker()).appearance is None
    typed = "track", video, "-o", tmp_path / "run", "--model", tmp_path / "bare.face"
    assert "bare.face has no texture to compare" in refused(*typed, "--terms", "colour+texture")


def test_recordings_shorter_than_a_second_are_counted_too():
    short = SimpleNamespace(postures=np.zeros((10, 3)), run={"rate": 25.0})
    assert _few([short]) == (
        "warning: 1 recording of 0.4 s in all; 5 recordings of 3 s are enough; with one of 2 s, "
        "people who change their expression are often tracked worse than without a face"
    )
    assert _few([short] * 5) == ""


def test_half_an_appearance_is_refused(learned, tmp_path):
    with np.load(learned[0]) as data:
        left = {name: data[name] for name in data.files if name != "la_lin.spread"}
    with (tmp_path / "half.face").open("wb") as file:
        np.savez(file, **left)
    with pytest.raises(ModelFormatError, match="complete"):
        load_speaker_face(tmp_path / "half.face", load_speaker())


def test_recordings_that_cannot_be_used_are_refused(video, refused, tmp_path):
    output = tmp_path / "me.face"
    assert "does not exist" in refused("speaker", tmp_path / "none.mp4", "-o", output)
    other = write_noise(tmp_path / "noise.mp4")
    assert "noise.mp4 has 96x80 pixels" in refused("speaker", video, other, "-o", output)
    assert "no face" in refused("speaker", other, "-o", output)
