"""Where the video of a run is looked for."""

from __future__ import annotations

import json

import pytest
from inspected import write_run, write_video

from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.dataset.sums import digest
from abs_engine.io.assets import load_speaker
from abs_engine.report.inspect.run_video import find_video
from abs_engine.report.inspect.runs import load_run_head


@pytest.fixture
def run(tmp_path, monkeypatch):
    """A run whose video is nowhere, in runs/one, seen from the folder above."""
    (tmp_path / "runs").mkdir()
    monkeypatch.chdir(tmp_path)
    return load_run_head(write_run(tmp_path / "runs/one"), load_speaker())


def tell(run, **settings):
    told = json.dumps({"settings": settings})
    (run.folder / "run.json").write_text(told, encoding="utf-8")


@pytest.mark.parametrize(
    "place", ["video.mp4", "runs/video.mp4", "runs/clip/video.mp4", "runs/one/video.mp4"]
)
def test_it_lies_here_or_near_the_run(run, tmp_path, place):
    (tmp_path / place).parent.mkdir(exist_ok=True)
    write_video(tmp_path / place)
    assert find_video(run, None).resolve() == tmp_path / place


def test_it_lies_where_the_run_says_or_beside_the_truth(run, tmp_path):
    (tmp_path / "films").mkdir()
    film = write_video(tmp_path / "films/talk.mp4")
    tell(run, video="films/talk.mp4")
    assert find_video(run, None).resolve() == film
    tell(run, video="gone.mp4")
    assert find_video(run, None, film) == film
    assert find_video(run, film) == film
    with pytest.raises(InputFileError, match=r"gone.mp4 is not beside the run .* with --truth DIR"):
        find_video(run, None)


def test_it_lies_where_it_was_when_it_was_tracked(run, tmp_path):
    (tmp_path / "films").mkdir()
    film = write_video(tmp_path / "films/talk.mp4")
    tell(run, video="talk.mp4", video_path="../../films/talk.mp4")
    assert find_video(run, None).resolve() == film
    film.unlink()
    with pytest.raises(InputFileError, match="nor where it was"):
        find_video(run, None)


def test_of_several_it_is_the_one_with_the_checksum(run, tmp_path):
    other, film = write_video(tmp_path / "video.mp4"), write_video(tmp_path / "runs/video.mp4")
    with film.open("ab") as file:
        file.write(b"more")
    tell(run, video="video.mp4")
    assert find_video(run, None).resolve() == other
    tell(run, video="video.mp4", video_sha256=digest(film))
    assert find_video(run, None).resolve() == film
    tell(run, video="video.mp4", video_sha256="0" * 64)
    with pytest.raises(InputFileError, match="its checksum is another; give that one with --vid"):
        find_video(run, None)


def test_what_is_given_may_be_a_copy_but_not_of_another_length(run, tmp_path, caplog):
    film = write_video(tmp_path / "film.mp4")
    tell(run, video="gone.mp4", video_sha256=digest(film))
    assert find_video(run, film) == film
    assert not caplog.records
    copy = write_video(tmp_path / "copy.mp4", crf=0)
    assert find_video(run, copy) == copy
    (line,) = caplog.records
    assert "copy.mp4 is not the file that was tracked: its checksum differs" in line.getMessage()
    longer = write_video(tmp_path / "longer.mp4", times=2)
    with pytest.raises(
        ParameterError,
        match=r"longer.mp4 and the run differ in number of frames: 6 and 3; give the tracked",
    ):
        find_video(run, longer)


@pytest.mark.parametrize("text", ["", "[1]", "{}", '{"settings": {"video": 3}}', None])
def test_a_run_that_does_not_name_it(run, text):
    if text is None:
        (run.folder / "run.json").unlink()
    else:
        (run.folder / "run.json").write_text(text)
    with pytest.raises(InputFileError, match="does not name the video; give it with --video"):
        find_video(run, None)
