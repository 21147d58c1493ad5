"""A run of another clip is recognised by its video's checksum and its frame rate."""

from __future__ import annotations

import hashlib
import json
import shutil

import numpy as np
import pytest
from results import RATE, clip, write_dataset, write_run

from abs_engine.cli import main
from abs_engine.core.errors import OtherClipError
from abs_engine.dataset import load_truth, write_sums
from abs_engine.dataset.sums import SUMS
from abs_engine.evaluate.same_clip import check_clip, video_sum


@pytest.fixture(scope="module")
def truth():
    return clip()


@pytest.fixture(scope="module")
def dataset(truth, tmp_path_factory):
    """Two views of the same size, rate and number of frames, with different videos."""
    folder = write_dataset(tmp_path_factory.mktemp("data") / "set", truth)
    shutil.copytree(folder / "clip", folder / "other")
    (folder / "other" / "camera" / "video.mp4").write_bytes(b"other pictures")
    record = json.loads((folder / "dataset.json").read_text())
    record["clips"].append({**record["clips"][0], "name": "other"})
    (folder / "dataset.json").write_text(json.dumps(record))
    write_sums(folder)
    return folder


def run_of(folder, truth, video, **arrays):
    """A run that says that it was made from a video of these bytes."""
    run = write_run(folder, truth, **arrays)
    told = {"settings": {"video_sha256": hashlib.sha256(video).hexdigest()}}
    (run / "run.json").write_text(json.dumps(told))
    return run


def evaluate(run, truth, out):
    return main(["evaluate", str(run), "--truth", str(truth), "-o", str(out)])


def test_the_view_that_was_tracked_is_told_from_another(truth, dataset, tmp_path, capsys, caplog):
    run = run_of(tmp_path / "run", truth, b"other pictures")
    assert evaluate(run, dataset / "other/camera", tmp_path / "right") == 0
    assert not caplog.records
    capsys.readouterr()
    assert evaluate(run, dataset / "clip/camera", tmp_path / "wrong") == 2
    said = capsys.readouterr().err
    assert "is of other/camera/video.mp4 of the same dataset" in said
    assert f"--truth {dataset / 'other/camera'}" in said
    assert not (tmp_path / "wrong").exists()


def test_a_video_that_is_not_in_the_dataset(truth, dataset, tmp_path):
    run = run_of(tmp_path / "run", truth, b"a stranger's")
    with pytest.raises(OtherClipError, match="another video than the truth's"):
        check_clip(run, {}, load_truth(dataset / "clip/camera"))


def test_another_frame_rate(truth, dataset, tmp_path):
    seen = load_truth(dataset / "clip/camera")
    run = run_of(tmp_path / "run", truth, b"no pictures are needed here")
    check_clip(run, {"rate": np.array(RATE * 1.001)}, seen)
    for rate in (24.0, 30.0):
        with pytest.raises(OtherClipError, match=f"{rate:g} frames a second, the truth {RATE:g}"):
            check_clip(run, {"rate": np.array(rate)}, seen)


def test_a_video_of_which_the_dataset_has_no_checksum_may_be_the_one(truth, dataset, tmp_path):
    other = shutil.copytree(dataset, tmp_path / "set")
    sums = (other / SUMS).read_text().splitlines(keepends=True)
    (other / SUMS).write_text("".join(s for s in sums if "clip/camera/video.mp4" not in s))
    run = run_of(tmp_path / "run", truth, b"no pictures are needed here")
    check_clip(run, {}, load_truth(other / "clip/camera"))


def test_the_view_is_found_by_the_video_or_named(truth, dataset, tmp_path, capsys):
    run = run_of(tmp_path / "run", truth, b"other pictures")
    assert evaluate(run, dataset, tmp_path / "found") == 0
    assert json.loads((tmp_path / "found/scores.json").read_text())["views"] == ["other/camera"]
    old = write_run(tmp_path / "old", truth)
    assert evaluate(old, dataset, tmp_path / "open") == 2
    assert "choose with --clip and --camera" in capsys.readouterr().err
    words = ["evaluate", str(old), "--truth", str(dataset), "-o", str(tmp_path / "named")]
    assert main([*words, "--clip", "other", "--camera", "camera"]) == 0
    assert json.loads((tmp_path / "named/scores.json").read_text())["views"] == ["other/camera"]


def test_an_old_run_is_taken_at_its_word(truth, dataset, tmp_path, caplog):
    run, seen = write_run(tmp_path / "run", truth), load_truth(dataset / "clip/camera")
    for told in (None, "[]", '{"settings": {}}', "{"):
        caplog.clear()
        if told is not None:
            (run / "run.json").write_text(told)
        assert video_sum(run) is None
        check_clip(run, {}, seen)
        assert "does not say of which video it is" in caplog.text
    caplog.clear()
    assert evaluate(run, dataset / "clip/camera", tmp_path / "out") == 0
    assert "does not say of which video it is" in caplog.text
