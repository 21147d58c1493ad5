"""Output appears whole or not at all."""

from __future__ import annotations

import errno
import fcntl
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from abs_engine.core.errors import BusyOutputError, OutputError, SameOutputError
from abs_engine.io import naming
from abs_engine.io.files import check_free, parent_folder, write_new
from abs_engine.io.naming import CHOICES, RECORD, WHOLE, partial_of
from abs_engine.io.new_folder import NewFolder
from abs_engine.io.unfinished import Unfinished, check_output

ROOT = Path(__file__).resolve().parents[2]


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
        monkeypatch.setattr(naming, "_rename_only", fail)
        with pytest.raises(OutputError, match="No space left"):
            made.finish()
    assert not list(tmp_path.iterdir())


def appearing(place, rename):
    """A rename before which somebody else takes the name."""

    def first(made, to):
        place.write_text("mine")
        rename(made, to)

    return first


def test_a_file_that_appeared_in_the_meantime_is_kept(tmp_path, monkeypatch):
    file = tmp_path / "file"
    monkeypatch.setattr(naming, "_rename_only", appearing(file, naming._rename_only))
    with pytest.raises(OutputError, match="exists already"):
        write_new(file, b"ours")
    assert file.read_text() == "mine"
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("taken", [False, True])
def test_a_drive_that_cannot_rename_without_replacing(tmp_path, monkeypatch, taken):
    def unknown(*_: object) -> None:
        raise OSError(errno.EINVAL, os.strerror(errno.EINVAL))

    monkeypatch.setattr(naming, "_rename_only", unknown)
    made, place = tmp_path / "made", tmp_path / "place"
    made.mkdir()
    if taken:
        place.mkdir()
        with pytest.raises(FileExistsError):
            naming.rename_new(made, place)
    else:
        naming.rename_new(made, place)
    assert (made.exists(), place.exists()) == (taken, True)


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


@pytest.mark.parametrize(
    ("flags", "why"), [(0, "Permission denied"), (os.ST_RDONLY, "Read-only file system")]
)
def test_a_folder_that_takes_nothing_is_named_before_the_work(tmp_path, monkeypatch, flags, why):
    monkeypatch.setattr(os, "access", lambda path, mode: path != tmp_path)  # root may write to all
    monkeypatch.setattr(os, "statvfs", lambda _path: SimpleNamespace(f_flag=flags))
    with pytest.raises(OutputError, match=rf"model.npz cannot be written \({why}\)"):
        check_free(tmp_path / "model.npz", ".npz")


def test_a_name_that_is_too_long_is_refused_before_the_work(tmp_path):
    check_free(tmp_path / ("a" * 240))
    for name in ("a" * 250, "a" * 300):
        with pytest.raises(OutputError, match=r"\(File name too long\); choose a shorter name"):
            check_free(tmp_path / name)


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


@pytest.mark.parametrize("make", [NewFolder, lambda folder: Unfinished(folder, "choices")])
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
    claim = NewFolder(tmp_path / "out")
    before = _open_files()
    with pytest.raises(OutputError, match="another process makes"):
        NewFolder(tmp_path / "out")
    assert _open_files() == before
    claim.release()
    other = os.open(tmp_path, os.O_RDONLY)  # gets the number that was the claim's
    claim.release()
    os.fstat(other)
    os.close(other)
    NewFolder(tmp_path / "out").discard()
    assert not list(tmp_path.iterdir())


def left_by_a_kill(target, *names):
    """What lies beside an output whose process was killed."""
    for name in names:
        (partial_of(target) / name).mkdir(parents=True)
    return partial_of(target)


def test_what_a_killed_process_left_is_taken_away_first(tmp_path):
    target = tmp_path / "out"
    (left_by_a_kill(target, WHOLE) / WHOLE / "half").touch()
    with NewFolder(target) as made:
        assert not list(made.work.iterdir())
        made.finish()
    assert [p.name for p in tmp_path.iterdir()] == ["out"]


def test_what_an_interrupted_command_kept_is_not_taken_away_by_another(tmp_path):
    with Unfinished(tmp_path / "out", "same") as made:
        (made.work / "done").touch()
    with pytest.raises(OutputError, match="holds what an interrupted command had kept"):
        NewFolder(tmp_path / "out")
    with Unfinished(tmp_path / "out", "same") as again:
        assert (again.work / "done").is_file()


@pytest.mark.parametrize("make", [NewFolder, lambda folder: Unfinished(folder, "choices")])
def test_a_disk_that_is_full_at_once_leaves_nothing(tmp_path, monkeypatch, make):
    def fail(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_text", fail)
    if make is NewFolder:
        monkeypatch.setattr(NewFolder, "_begin", fail)
    with pytest.raises(OutputError, match="No space left"):
        make(tmp_path / "out")
    assert not list(tmp_path.iterdir())


def test_killed_once_it_was_named_only_the_remains_are_taken_away(tmp_path):
    target = tmp_path / "out"
    target.mkdir()
    partial = left_by_a_kill(target, "journal")
    (partial / CHOICES).write_text("same")
    with pytest.raises(OutputError, match="exists already"):
        Unfinished(target, "same")
    assert [p.name for p in tmp_path.iterdir()] == ["out"]
    target.rename(tmp_path / "moved")
    (left_by_a_kill(target, "journal") / CHOICES).write_text("same")
    with Unfinished(target, "same") as anew:
        assert not anew.resumed
        anew.finish()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["moved", "out"]


def finished(target, *choices):
    """A folder with a file, made with these choices, and the bytes of what it holds."""
    with Unfinished(target, *choices) as made:
        (made.work / "deep").mkdir()
        (made.work / "deep" / "file").write_text("x")
        made.finish()
    return held(target)


def held(folder):
    """The bytes of the files of a folder, and when they were written."""
    files = [path for path in folder.rglob("*") if path.is_file()]
    return {path: (path.read_bytes(), path.stat().st_mtime_ns) for path in files}


def test_made_again_with_the_same_choices_it_is_left_as_it_is(tmp_path):
    before = finished(tmp_path / "out", "same", "", "much")
    assert {path.name for path in before} == {"file", RECORD}
    check_output(tmp_path / "out")
    with pytest.raises(SameOutputError, match="out already exists and is complete"):
        Unfinished(tmp_path / "out", "same", also="much")
    (tmp_path / "out" / "mine").touch()
    with pytest.raises(SameOutputError):
        Unfinished(tmp_path / "out", "same", also="much")
    (tmp_path / "out" / "mine").unlink()
    assert held(tmp_path / "out") == before
    assert [p.name for p in tmp_path.iterdir()] == ["out"]


@pytest.mark.parametrize("choices", [("other", "much"), ("same", "more"), ("", "much")])
def test_made_again_with_other_choices_it_exists_already(tmp_path, choices):
    before = finished(tmp_path / "out", "same", "", "much")
    with pytest.raises(OutputError, match="exists already") as caught:
        Unfinished(tmp_path / "out", choices[0], also=choices[1])
    assert not isinstance(caught.value, SameOutputError)
    assert held(tmp_path / "out") == before


@pytest.mark.parametrize(
    "harm",
    [
        lambda out: (out / "deep" / "file").unlink(),
        lambda out: (out / RECORD).write_bytes(b""),
        lambda out: (out / RECORD).write_bytes(b"\xff\n"),
        lambda out: (out / RECORD).unlink(),
    ],
)
def test_what_is_no_longer_whole_exists_already(tmp_path, harm):
    finished(tmp_path / "out", "same")
    harm(tmp_path / "out")
    with pytest.raises(OutputError, match="exists already"):
        Unfinished(tmp_path / "out", "same")


def test_a_file_that_is_missing_is_named(tmp_path):
    finished(tmp_path / "out", "same")
    (tmp_path / "out" / "deep" / "file").unlink()
    with pytest.raises(OutputError, match="by the same command, but deep/file is missing"):
        Unfinished(tmp_path / "out", "same")
    with pytest.raises(OutputError, match="of other input"):
        Unfinished(tmp_path / "out", "other")


def test_what_was_begun_with_other_choices_is_known_to_be_gone(tmp_path):
    with Unfinished(tmp_path / "out", "same", anew="it") as made:
        assert not made.replaced
    with Unfinished(tmp_path / "out", "same", anew="it") as made:
        assert made.resumed
        assert not made.replaced
    with Unfinished(tmp_path / "out", "other", anew="it") as made:
        assert made.replaced


@pytest.mark.parametrize("other", ["", "other"])
def test_what_another_command_had_kept_is_not_taken_away(tmp_path, other):
    with Unfinished(tmp_path / "out", "same", anew=other) as made:
        (made.work / "done").touch()
    with pytest.raises(OutputError, match="holds what an interrupted command had kept; finish"):
        Unfinished(tmp_path / "out", "same", anew="it")
    with Unfinished(tmp_path / "out", "same", anew=other) as again:
        assert (again.work / "done").is_file()


def test_what_another_machine_finished_is_known_but_not_gone_on_with(tmp_path):
    with Unfinished(tmp_path / "out", "same", anew="it", by="one") as made:
        (made.work / "done").touch()
    with Unfinished(tmp_path / "out", "same", anew="it", by="one") as again:
        assert again.resumed
    with Unfinished(tmp_path / "out", "same", anew="it", by="other") as again:
        assert not again.resumed
        assert not list(again.work.iterdir())
        again.finish()
    with pytest.raises(SameOutputError):
        Unfinished(tmp_path / "out", "same", anew="it", by="one")


@pytest.mark.parametrize("place", ["", ".", "..", "/"])
def test_a_place_without_a_name_exists_already(place):
    for make in (NewFolder, check_output, check_free):
        with pytest.raises(OutputError, match="exists already"):
            make(Path(place))


def test_choices_that_count_at_the_end_alone_do_not_hinder_going_on(tmp_path):
    with Unfinished(tmp_path / "out", "same", also="much") as made:
        (made.work / "done").touch()
    with Unfinished(tmp_path / "out", "same", also="more") as again:
        assert again.resumed
        again.finish()
    with pytest.raises(SameOutputError):
        Unfinished(tmp_path / "out", "same", also="more")


def test_killed_between_its_name_and_the_tidying_it_is_there_whole(tmp_path, monkeypatch):
    target = tmp_path / "out"
    monkeypatch.setattr(Unfinished, "discard", Unfinished.release)
    before = finished(target, "same")
    monkeypatch.undo()
    assert (partial_of(target) / CHOICES).is_file()
    with pytest.raises(SameOutputError):
        Unfinished(target, "same")
    assert [p.name for p in tmp_path.iterdir()] == ["out"]
    assert held(target) == before


def test_of_two_at_once_the_later_one_is_refused_until_the_first_is_done(tmp_path, monkeypatch):
    target = tmp_path / "out"
    with Unfinished(target, "same") as first:
        with pytest.raises(BusyOutputError):
            Unfinished(target, "same")
        first.finish()
    claimed = Unfinished._claimed

    def later(made):
        if made.target == tmp_path / "other" and not made.target.exists():
            monkeypatch.undo()
            finished(made.target, "same")  # between the look and the claim
        return claimed(made)

    monkeypatch.setattr(Unfinished, "_claimed", later)
    with pytest.raises(SameOutputError):
        Unfinished(tmp_path / "other", "same")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["other", "out"]


def test_what_can_be_gone_on_with_is_kept_beside_a_folder_of_its_name(tmp_path):
    with Unfinished(tmp_path / "out", "same") as made:
        (made.work / "done").touch()
    (tmp_path / "out").mkdir()
    with pytest.raises(OutputError, match="exists already"):
        Unfinished(tmp_path / "out", "same")
    assert (made.work / "done").is_file()


def test_a_file_half_written_by_a_killed_process_is_no_hindrance(tmp_path):
    partial_of(tmp_path / "file").write_bytes(b"longer than what is written")
    write_new(tmp_path / "file", b"1")
    assert (tmp_path / "file").read_bytes() == b"1"
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("after", range(1, 7))
def test_killed_at_any_call_the_same_goes_on_and_leaves_nothing(tmp_path, after):
    """In a process that ends, without a word, at its n-th call of the file system."""
    code = f"""
import os, sys
from pathlib import Path
from abs_engine.io.unfinished import Unfinished
left = {after}
def heard(event, _given):
    global left
    if event in ("os.mkdir", "os.rename", "os.rmdir", "os.remove", "fcntl.flock"):
        left -= 1
        if not left:
            os._exit(9)
sys.addaudithook(heard)
with Unfinished(Path({str(tmp_path / "out")!r}), "same") as made:
    (made.work / "done").write_text("x")
    made.finish()
"""
    subprocess.run([sys.executable, "-c", code], check=False, cwd=ROOT)
    try:
        with Unfinished(tmp_path / "out", "same") as made:
            (made.work / "done").write_text("x")
            made.finish()
    except SameOutputError:
        assert (tmp_path / "out").is_dir()  # it had its name already
    assert [p.name for p in tmp_path.iterdir()] == ["out"]
    assert (tmp_path / "out" / "done").read_text() == "x"
