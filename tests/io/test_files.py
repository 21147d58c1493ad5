"""Output appears whole or not at all."""

from __future__ import annotations

import errno
import fcntl
import os

import pytest

from abs_engine.core.errors import OutputError
from abs_engine.io.files import NewFolder, parent_folder, write_new
from abs_engine.io.unfinished import Claim, Unfinished, partial_of


def test_a_folder_appears_at_the_end(tmp_path):
    with NewFolder(tmp_path / "out") as made:
        (made.work / "file").write_text("x")
        assert not (tmp_path / "out").exists()
        made.finish()
    assert [p.name for p in tmp_path.iterdir()] == ["out"]
    assert (tmp_path / "out" / "file").read_text() == "x"
    mask = os.umask(0)
    os.umask(mask)
    assert (tmp_path / "out").stat().st_mode & 0o777 == 0o777 & ~mask


def stop(folder, error):
    """Begin a folder and fail."""
    with NewFolder(folder) as made:
        (made.work / "deep").mkdir()
        (made.work / "deep" / "file").touch()
        raise error


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError, OSError(28, "No space left")])
def test_nothing_is_left_after_an_error(tmp_path, error):
    wanted = OutputError if isinstance(error, OSError) else error
    with pytest.raises(wanted):
        stop(tmp_path / "out", error)
    assert not list(tmp_path.iterdir())


def test_a_folder_made_in_the_meantime_is_kept(tmp_path):
    with NewFolder(tmp_path / "out") as made:
        (tmp_path / "out").mkdir()
        (tmp_path / "out" / "mine").touch()
        with pytest.raises(OutputError):
            made.finish()
    assert [p.name for p in tmp_path.iterdir()] == ["out"]
    assert [p.name for p in (tmp_path / "out").iterdir()] == ["mine"]


def test_an_empty_folder_made_in_the_meantime_is_not_replaced(tmp_path):
    with NewFolder(tmp_path / "out") as made:
        (made.work / "file").touch()
        (tmp_path / "out").mkdir()
        with pytest.raises(OutputError, match="exists already"):
            made.finish()
    assert [p.name for p in tmp_path.iterdir()] == ["out"]
    assert not list((tmp_path / "out").iterdir())


def test_a_folder_that_cannot_be_named_leaves_no_empty_one(tmp_path, monkeypatch):
    def fail(*_: object) -> None:
        raise OSError(28, "No space left")

    with NewFolder(tmp_path / "out") as made:
        monkeypatch.setattr(os, "rename", fail)
        with pytest.raises(OutputError, match="No space left"):
            made.finish()
    assert not list(tmp_path.iterdir())


def test_a_file_that_appeared_in_the_meantime_is_kept(tmp_path, monkeypatch):
    whole = os.chmod

    def appear(*words: object) -> None:  # the last step before the file gets its name
        (tmp_path / "file").write_text("mine")
        whole(*words)

    monkeypatch.setattr(os, "chmod", appear)
    with pytest.raises(OutputError, match="exists already"):
        write_new(tmp_path / "file", b"ours")
    assert (tmp_path / "file").read_text() == "mine"
    assert len(list(tmp_path.iterdir())) == 1


def test_a_parent_made_for_an_output_that_failed_is_taken_away(tmp_path):
    def work(error: type[BaseException] | None, name: str) -> None:
        with parent_folder(tmp_path / "runs" / name):
            assert (tmp_path / "runs").is_dir()
            if error is not None:
                raise error
            (tmp_path / "runs" / name).mkdir()

    with pytest.raises(KeyboardInterrupt):
        work(KeyboardInterrupt, "demo")
    assert not list(tmp_path.iterdir())
    work(None, "demo")
    with pytest.raises(ValueError):  # noqa: PT011
        work(ValueError, "demo-2")  # was there before, and is kept
    assert [p.name for p in (tmp_path / "runs").iterdir()] == ["demo"]
    with (
        pytest.raises(OutputError, match="cannot be written"),
        parent_folder(tmp_path / "a" / "b" / "c"),
    ):
        pass


def test_a_new_file_is_written_once(tmp_path):
    write_new(tmp_path / "file", b"1")
    with pytest.raises(OutputError, match="exists already"):
        write_new(tmp_path / "file", b"2")
    assert (tmp_path / "file").read_bytes() == b"1"
    assert len(list(tmp_path.iterdir())) == 1


def _open_files() -> set[str]:
    """What this process has open, by its number."""
    found = set()
    for number in os.listdir("/proc/self/fd"):
        try:
            found.add(number + os.readlink(f"/proc/self/fd/{number}"))
        except FileNotFoundError:  # the listing itself
            continue
    return found


@pytest.mark.parametrize("make", [Claim, lambda folder: Unfinished(folder, "choices")])
def test_a_drive_without_locks_is_named_and_nothing_stays_open(tmp_path, monkeypatch, make):
    def fail(*_: object) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(fcntl, "flock", fail)
    before = _open_files()
    with pytest.raises(OutputError, match=r"cannot be locked \(No locks available\)"):
        make(tmp_path / "out")
    assert _open_files() == before
    assert not list(tmp_path.iterdir())
    partial_of(tmp_path / "out").mkdir()
    (partial_of(tmp_path / "out") / "done").touch()
    with pytest.raises(OutputError):
        make(tmp_path / "out")
    assert (partial_of(tmp_path / "out") / "done").is_file()  # what was begun is kept


def test_a_claim_keeps_others_off_and_may_be_released_twice(tmp_path):
    claim = Claim(tmp_path / "out")
    before = _open_files()
    with pytest.raises(OutputError, match="another process makes"):
        Claim(tmp_path / "out")
    assert _open_files() == before
    claim.release()
    other = os.open(tmp_path, os.O_RDONLY)  # gets the number that was the claim's
    claim.release()
    os.fstat(other)
    os.close(other)
    Claim(tmp_path / "out").release()
