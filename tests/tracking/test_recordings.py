"""Which recordings a speaker's face can be learned from, and which of their frames."""

from __future__ import annotations

import json
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
from runs import write_noise, written_run

from abs_engine.core.errors import (
    InputFileError,
    OtherPersonError,
    ParameterError,
    TooFewFramesError,
)
from abs_engine.io.assets import load_speaker
from abs_engine.tracking.recordings import (
    Recording,
    check_one_camera,
    check_same,
    check_variety,
    load_recording,
)

FRAMES = 50


def recording(name="one.mp4", aperture=None, widened=0.0):
    """A recording of the bundled head, made so much wider."""
    aperture = np.linspace(0, 12, FRAMES) if aperture is None else aperture
    count = len(aperture)
    no = np.zeros(count, np.bool_)
    arrays = {
        "index": np.arange(count), "found": ~no, "covered": no, "contradicted": no,
        "status": np.full(count, "converged"), "aperture": aperture,
        "width": np.linspace(50, 40, count),
    }  # fmt: skip
    head = load_speaker().vertices * np.array([1 + widened, 1, 1], np.float32)
    return Recording(Path(name), arrays, head, np.zeros((count, 3)))


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


def test_videos_of_two_sizes_are_refused():
    sizes = [(Path("a.mp4"), (320, 240)), (Path("b.mp4"), (640, 480))]
    with pytest.raises(ParameterError, match=r"b\.mp4 has 640x480 pixels"):
        check_one_camera(sizes)


def test_its_video_is_taken_from_where_the_run_says_that_it_was(tmp_path):
    run = written_run(tmp_path / "run", [0, 1])
    (tmp_path / "elsewhere").mkdir()
    video = write_noise(tmp_path / "elsewhere" / "talk.mp4")
    summary = json.loads((run / "run.json").read_text())
    named = {"video": video.name, "video_sha256": sha256(video.read_bytes()).hexdigest()}
    summary["settings"] = {**named, "video_path": "../elsewhere/talk.mp4"}
    (run / "run.json").write_text(json.dumps(summary))
    assert load_recording(run).video.samefile(video)
    video.rename(tmp_path / "talk.mp4")
    assert load_recording(run).video.samefile(tmp_path / "talk.mp4")
    (tmp_path / "talk.mp4").unlink()
    with pytest.raises(InputFileError, match="is not there"):
        load_recording(run)


def test_a_folder_that_is_no_run_is_refused(tmp_path):
    with pytest.raises(InputFileError, match=str(tmp_path)):
        load_recording(tmp_path)
