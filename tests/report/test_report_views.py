"""Which clip and camera a report is about."""

from __future__ import annotations

import hashlib
import json
import shutil

import pytest
import reported

from abs_engine.cli import main
from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.dataset import ClipEntry, dataset_record, write_sums
from abs_engine.dataset.dataset import read_record
from abs_engine.evaluate.clip_views import shown_view


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Clip `clip` by `camera` and `side`, and clip `other` by `camera`."""
    folder = reported.write_dataset(tmp_path_factory.mktemp("views") / "data")
    shutil.copytree(folder / "clip/camera", folder / "clip/side")
    shutil.copytree(folder / "clip", folder / "other")
    shutil.rmtree(folder / "other/side")
    for number, view in enumerate(("clip/side", "other/camera"), 1):
        with (folder / view / "video.mp4").open("ab") as file:
            file.write(bytes(number))  # another checksum, the same film
    entry = read_record(folder).clips[0]
    clips = [
        ClipEntry(name, entry.person, "", entry.frames, entry.rate, cameras)
        for name, cameras in (("clip", ("camera", "side")), ("other", ("camera",)))
    ]
    record = dataset_record(command="", seed=0, engine="", clips=clips, labels=())
    (folder / "dataset.json").write_text(json.dumps(record))
    write_sums(folder)
    return folder


def run_of(folder, video):
    """A perfect run that keeps the checksum of its video."""
    reported.write_exact(folder)
    told = json.loads((folder / "run.json").read_text())
    digest = hashlib.sha256(video.read_bytes()).hexdigest()
    told["settings"]["video_sha256"] = digest
    (folder / "run.json").write_text(json.dumps(told))
    return folder


@pytest.mark.parametrize(
    ("path", "clip", "camera", "found"),
    [
        ("", "clip", "side", "clip/side"),
        ("", "other", None, "other/camera"),
        ("", None, "side", "clip/side"),
        ("clip", None, "camera", "clip/camera"),
        ("clip/side", None, None, "clip/side"),
    ],
)
def test_a_view_is_chosen_by_path_and_by_names(data, path, clip, camera, found):
    truth, others = shown_view(data / path, clip, camera)
    assert truth.folder == data / found
    assert len(others) == 2
    assert found not in others


def test_what_is_open_or_is_not_there_is_told_in_one_line(data, tmp_path):
    with pytest.raises(ParameterError, match="clip/camera, clip/side, other/camera; choose"):
        shown_view(data, None, None)
    with pytest.raises(ParameterError, match="has no view 'top'; there are clip/camera"):
        shown_view(data, None, "top")
    with pytest.raises(ParameterError, match="has no view 'other/side'"):
        shown_view(data / "other", None, "side")
    with pytest.raises(InputFileError, match="not ground truth"):
        shown_view(tmp_path, None, None)


def test_a_run_that_knows_its_video_needs_no_choice(data, tmp_path):
    side = run_of(tmp_path / "a", data / "clip/side/video.mp4")
    other = run_of(tmp_path / "b", data / "other/camera/video.mp4")
    assert shown_view(data, None, None, [side])[0].folder == data / "clip/side"
    assert shown_view(data, None, None, [other])[0].folder == data / "other/camera"
    with pytest.raises(ParameterError, match="the runs are of clip/side, not of other/camera"):
        shown_view(data, "other", None, [side])
    with pytest.raises(ParameterError, match=r"several .a of clip/side, b of other/camera.; write"):
        shown_view(data, None, None, [side, other])


def test_a_run_of_none_of_the_views_is_said_to_be_of_none(data, tmp_path):
    (tmp_path / "film.mp4").write_bytes(b"another film")
    run = run_of(tmp_path / "run", tmp_path / "film.mp4")
    said = r"holds 3 views, none of the video of .*run, and one is needed: .*; give the truth of "
    with pytest.raises(ParameterError, match=said):
        shown_view(data, None, None, [run])


def test_the_page_tells_which_view_it_shows(data, tmp_path, capsys):
    run = reported.write_exact(tmp_path / "run")
    words = ["report", str(run), "--truth", str(data), "-o", str(tmp_path / "page.html")]
    assert main(words) == 2
    assert "--clip and --camera" in capsys.readouterr().err
    assert main([*words, "--clip", "clip", "--camera", "side"]) == 0
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "Clip <b>clip</b> by camera <b>side</b>" in page
    assert "also in the dataset: clip/camera, other/camera." in page
    assert "--clip clip --camera side" in page
    words[-1] = str(tmp_path / "more.html")
    assert main([*words[:2], "-o", words[-1], "--clip", "clip"]) == 2
    assert "give --truth" in capsys.readouterr().err
