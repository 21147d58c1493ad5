"""Which recordings a speaker's face can be learned from, and which of their frames."""

from __future__ import annotations

import json
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from runs import noise, write_kind, write_noise, written_run

from abs_engine.cli import main
from abs_engine.core.errors import (
    InputFileError,
    ModelFormatError,
    OtherPersonError,
    ParameterError,
    TooFewFramesError,
)
from abs_engine.io.assets import load_speaker
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.recordings import (
    Recording,
    check_distinct,
    check_same,
    check_variety,
    check_videos,
    load_recording,
)
from abs_engine.tracking.scale import USUAL_PUPILS
from abs_engine.tracking.speaker_learning import Learned, Learner, learn_speaker

FRAMES = 50


def recording(name="one.mp4", aperture=None, widened=0.0, larger=1.0):
    """A recording of the bundled head, made so much wider, and larger by its pupils' distance."""
    aperture = np.linspace(0, 12, FRAMES) if aperture is None else aperture
    count = len(aperture)
    no = np.zeros(count, np.bool_)
    arrays = {
        "index": np.arange(count), "found": ~no, "covered": no, "contradicted": no,
        "status": np.full(count, "converged"), "aperture": aperture,
        "width": np.linspace(50, 40, count),
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
    [(np.zeros(FRAMES), "no open mouth in 40 frames"), (np.full(FRAMES, 8.0), "no closed mouth")],
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


def test_heads_are_compared_in_one_size():
    check_same([recording("a.mp4"), recording("b.mp4", larger=1.26)], load_speaker())


def test_a_video_that_comes_twice_is_refused(tmp_path):
    one, other, run = tmp_path / "one.mp4", tmp_path / "other.mp4", tmp_path / "run"
    one.write_bytes(b"pictures")
    other.write_bytes(b"others")
    check_distinct([(one, one), (run, other)])
    with pytest.raises(ParameterError, match=r"one\.mp4 and .*run are of the same video"):
        check_distinct([(one, one), (other, other), (run, one)])


def test_speaker_refuses_a_video_that_is_typed_twice(tmp_path, capsys):
    one, other = (write_kind(tmp_path / f"{n}.mp4", "libx264", noise(2, seed=n)) for n in (1, 2))
    out = tmp_path / "me.face"
    assert main(["speaker", *map(str, (one, one, other)), "-o", str(out)]) == 2
    assert f"{one} and {one} are of the same video; give it once" in capsys.readouterr().err
    assert not out.exists()


def test_videos_of_one_size_are_asked_for(tmp_path):
    small, large = (
        write_kind(tmp_path / f"{name}.mp4", "libx264", noise(2, size, seed))
        for seed, (name, size) in enumerate([("a", (96, 80)), ("b", (128, 96))])
    )
    assert check_videos([(small, small)]) == (96, 80)
    with pytest.raises(ParameterError, match=r"b\.mp4 has 128x96 pixels, .*a\.mp4 96x80"):
        check_videos([(small, small), (tmp_path / "run", large)])
    with pytest.raises(ParameterError, match="are of the same video"):
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
    video.rename(tmp_path / "talk.mp4")
    assert load_recording(run, load_speaker()).video.samefile(tmp_path / "talk.mp4")
    with (tmp_path / "talk.mp4").open("ab") as file:
        file.write(b"more")
    with pytest.raises(InputFileError, match="has changed since it was tracked"):
        load_recording(run, load_speaker())
    (tmp_path / "talk.mp4").unlink()
    with pytest.raises(InputFileError, match="is not there"):
        load_recording(run, load_speaker())


def test_a_run_of_another_head_is_refused(run):
    other = replace(load_speaker(), faces=load_speaker().faces[:, ::-1])
    with pytest.raises(ModelFormatError, match="tracked with another head"):
        load_recording(run, other)


def test_a_folder_that_is_no_run_is_refused(tmp_path):
    with pytest.raises(InputFileError, match=str(tmp_path)):
        load_recording(tmp_path, load_speaker())


def test_a_face_is_not_learned_from_a_video_and_its_copy(tmp_path):
    one = write_noise(tmp_path / "one.mp4")
    other = tmp_path / "other.mp4"
    other.write_bytes(one.read_bytes())
    given = [replace(recording(), path=path, video=path) for path in (one, other)]
    with pytest.raises(ParameterError, match="are of the same video"):
        learn_speaker(given, CpuRenderer())


def test_of_too_few_frames_no_postures_are_learned_and_a_line_says_so():
    few = recording(aperture=np.linspace(0, 12, 48))
    assert few.usable.sum() == 38
    learner = Learner(*[None] * 5)
    assert learner.postures(None, [few]) is None
    face = SimpleNamespace(posture=SimpleNamespace(names=()), appearance=None)
    space = SimpleNamespace(own=False, left_out=(), expression=SimpleNamespace(variance=()))
    said = Learned(face, space, 38, (0.9,), 1).lines()[0]
    assert said == (
        "postures: anybody's, as 38 frames show the mouth well; a speaker's own need 40"
    )
