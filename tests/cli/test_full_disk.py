"""A disk, a stream or a folder that takes nothing: one line, status 2, nothing left behind."""

from __future__ import annotations

import subprocess
import sys

import pytest
from inspected import write_run, write_video
from runs import full

from abs_engine.cli import main

RUN = "import sys; from abs_engine.cli import main; sys.exit(main(sys.argv[1:]))"


@pytest.fixture
def fails(capsys, tmp_path):
    """Run a command that is to fail for want of space; its line."""

    def run(*words: object, size: int = 2000) -> str:
        before = sorted(tmp_path.rglob("*"))
        with full(size):
            status = main([str(word) for word in words])
        lines = capsys.readouterr().err.splitlines()
        assert status == 2
        assert len(lines) == 1, lines
        assert lines[0].startswith("abs-engine: error: ")
        assert sorted(tmp_path.rglob("*")) == before
        return lines[0]

    return run


def test_temporary_files_that_do_not_fit_in_a_report(fails, tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    run, video = write_run(tmp_path / "run"), write_video(tmp_path / "video.mp4")
    line = fails("report", run, "-o", tmp_path / "page.html", "--video", video, "--quiet")
    assert f"temporary files cannot be written to {tmp_path}" in line
    assert "TMPDIR" in line


def test_a_page_that_does_not_fit(fails, tmp_path):
    run, video = write_run(tmp_path / "run"), write_video(tmp_path / "video.mp4")
    line = fails(
        "report", run, "-o", tmp_path / "page.html", "--video", video, "--quiet", size=100_000
    )
    assert f"{tmp_path / 'page.html'} cannot be written" in line


def test_an_export_that_does_not_fit(fails, tmp_path):
    run = write_run(tmp_path / "run")
    assert "cannot be written" in fails("export", run, "--to", "obj", "-o", tmp_path / "obj")


@pytest.mark.parametrize("to", ["obj", "gltf"])
def test_a_folder_that_takes_nothing(fails, tmp_path, to):
    run = write_run(tmp_path / "run")
    output = {"obj": "/proc/new", "gltf": "/proc/new.glb"}[to]  # not even root may make one there
    line = fails("export", run, "--to", to, "-o", output, size=1 << 30)
    assert f"{output} cannot be written" in line


@pytest.mark.parametrize(
    ("words", "streams", "status"),
    [
        ("--version", ">/dev/full", 2),
        ("track none.mp4 -o run", ">/dev/full", 2),
        ("--version", ">/dev/full 2>/dev/full", 2),
        ("track none.mp4 -o run", "2>/dev/full", 2),
        ("track none.mp4 -o run", "2>&-", 2),
        ("--version", "2>&-", 0),
        ("--version", ">&-", 0),
    ],
)
def test_streams_that_take_nothing(words, streams, status, tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONUNBUFFERED", "")
    command = f'exec "{sys.executable}" -c "{RUN}" {words} {streams}'
    done = subprocess.run(
        ["sh", "-c", command], capture_output=True, text=True, cwd=tmp_path, check=False
    )
    assert done.returncode == status
    assert "Traceback" not in done.stderr
    assert len(done.stderr.splitlines()) == (status == 2 and "2>" not in streams)
    assert not list(tmp_path.iterdir())
