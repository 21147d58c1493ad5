"""Many clips in one command: names, the table, what fails, and what a second call keeps."""

from __future__ import annotations

import csv
import errno
import json
import logging
import os
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from distributed import CancelledError, Client, KilledWorker, LocalCluster
from distributed.deploy.spec import close_clusters
from drawn import lit
from heads import seen_at
from runs import full, write_kind
from short import Threads

from abs_engine.cli import main
from abs_engine.cli.parts.clips import _doubtful
from abs_engine.cli.parts.command import Done
from abs_engine.clips.cluster import replace_lost
from abs_engine.clips.job import FAILED, Job, Outcome, run_names
from abs_engine.clips.many import DEATHS, GIVEN_UP, _outcome, _Watched, track_many
from abs_engine.clips.table import TABLE, Table, rows_of_others, runs_folder
from abs_engine.clips.worker import check_same_options, track_job
from abs_engine.core.errors import OutputError, ParameterError
from abs_engine.core.release import engine_version
from abs_engine.dataset.sums import digest
from abs_engine.io.naming import partial_of, path_from
from abs_engine.tracking.options import TrackOptions
from abs_engine.tracking.results.frame_journal import FRAMES

OPEN = (0.0, 0.2, 0.3, 0.15, 0.05)


def test_a_run_is_named_as_its_clip():
    assert run_names([Path("s1/a.mp4"), Path("s1/b.mp4")]) == ["a", "b"]


def test_clips_named_alike_have_their_folder_s_name_before():
    given = [Path("s1/a.mp4"), Path("s2/a.mp4"), Path("s2/b.mp4")]
    assert run_names(given) == ["s1-a", "s2-a", "b"]


def test_a_name_too_long_for_files_beside_the_run_is_cut_at_a_character():
    long, other = "発話" * 41, "発話" * 40 + "終話"
    names = run_names([Path(f"{name}.mp4") for name in (long, other)])
    assert len(set(names)) == 2
    for name in names:
        assert name.startswith("発話" * 33)
        assert len(f"{name}.traceback.txt".encode()) < 255
    assert run_names([Path("a" * 200 + ".mp4")]) == ["a" * 200]


@pytest.mark.parametrize("other", ["s1/a.mp4", "s1/a.avi", "old/s1/a.mp4"])
def test_names_that_cannot_be_told_apart_are_refused(other):
    twice = other == "s1/a.mp4"
    said = f"{other} is given twice" if twice else f"a.mp4 and {other} would both be tracked to"
    with pytest.raises(ParameterError, match=said):
        run_names([Path("s1/a.mp4"), Path(other)])


def test_a_clip_given_by_two_paths_is_refused(tmp_path, monkeypatch, capsys):
    for name in ("s1", "s2"):
        (tmp_path / name).mkdir()
    monkeypatch.chdir(tmp_path / "s1")
    words = ["-o", str(tmp_path / "runs"), "--workers", "1", "--renderer", "cpu"]
    assert main(["track", "k.mp4", "../s1/k.mp4", *words]) == 2
    assert f"{tmp_path}/s1/k.mp4 is given twice; give it once" in capsys.readouterr().err
    assert main(["track", "../s2/../k.mp4", "../s2/../s1/../k.mp4", *words]) == 2
    assert f"{tmp_path}/k.mp4 is given twice; give it once" in capsys.readouterr().err


@pytest.mark.parametrize(
    "name",
    ["clips.csv.mp4", "timing.json.mp4", ".workers.mp4", "a.traceback.txt.mp4", ".a.partial.mp4",
     ".clips.csv.partial.mp4"],
)  # fmt: skip
def test_a_clip_named_as_something_else_beside_the_runs_is_refused(name):
    with pytest.raises(ParameterError, match="rename the video"):
        run_names([Path("s1/a.mp4"), Path(name)])


def test_a_name_that_is_no_utf_8_does_not_stop_the_table(tmp_path):
    (tmp_path / "runs").mkdir()
    Table(tmp_path / "runs", [job(tmp_path, "\udcff"), job(tmp_path)]).write({})
    lines = (tmp_path / "runs" / TABLE).read_text(encoding="utf-8").splitlines()
    assert lines[1:] == [r"\udcff,../\udcff.mp4,waiting,,,,", "a,../a.mp4,waiting,,,,"]


def job(folder: Path, name: str = "a") -> Job:
    return Job(folder / f"{name}.mp4", folder / "runs" / name, "cpu", TrackOptions(), (), {})


def test_the_table_is_whole_while_clips_wait(tmp_path):
    (tmp_path / "runs").mkdir()
    done = Outcome("done", "", 5, 4, 2, 9.75)
    Table(tmp_path / "runs", [job(tmp_path), job(tmp_path, "b")]).write({"b": done})
    assert (tmp_path / "runs" / TABLE).read_text() == (
        "clip,video,status,frames,found,closed,message\n"
        "a,../a.mp4,waiting,,,,\n"
        "b,../b.mp4,done,5,4,2,\n"
    )


def test_the_table_keeps_clips_of_earlier_commands(tmp_path):
    folder = tmp_path / "runs"
    folder.mkdir()
    first, strange = [job(tmp_path), job(tmp_path, "b")], job(tmp_path, "\udcff")
    done = Outcome("done", 'two\nlines, "quoted"', 5, 4, 2)
    Table(folder, [*first, strange]).write({"b": done})
    before = (folder / TABLE).read_text()
    later = [job(tmp_path, "c"), first[0], strange]
    Table(folder, later, rows_of_others(folder, later)).write({})
    with (folder / TABLE).open(newline="") as file:
        assert [row["clip"] for row in csv.DictReader(file)] == ["b", "c", "a", r"\udcff"]
    Table(folder, [*first, strange], rows_of_others(folder, [*later, *first])).write({"b": done})
    assert (folder / TABLE).read_text() == before


def test_a_table_that_takes_long_to_write_is_written_seldom(tmp_path, monkeypatch):
    folder, times = tmp_path / "runs", iter((0.0, 1.0, 20.9, 21.0, 21.0, 22.0))
    folder.mkdir()
    table = Table(folder, [job(tmp_path)])
    monkeypatch.setattr("abs_engine.clips.table.time", SimpleNamespace(monotonic=times.__next__))
    table.write({})  # takes a second
    before = (folder / TABLE).read_text()
    table.refresh({"a": Outcome("done")})
    assert (folder / TABLE).read_text() == before
    table.refresh({"a": Outcome("done")})
    assert "a,../a.mp4,done" in (folder / TABLE).read_text()


def test_paths_are_looked_up_once_and_an_interrupt_leaves_a_table_of_all_that_is_done(
    tmp_path, monkeypatch, capsys
):
    def done(_client: object, jobs: list[Job], _deaths: object) -> Iterator[tuple[Job, Outcome]]:
        for one in jobs[:-1]:
            yield one, Outcome("done", "", 5, 5, 2)
        raise KeyboardInterrupt

    def counted(*given: Path) -> str:
        looked.append(given)
        return path_from(*given)

    looked, names = [], [f"{k}.mp4" for k in range(20)]
    monkeypatch.setattr("abs_engine.clips.cluster.local_workers", lambda *_: nullcontext())
    monkeypatch.setattr("abs_engine.clips.many.track_many", done)
    monkeypatch.setattr("abs_engine.clips.table.path_from", counted)
    monkeypatch.chdir(tmp_path)
    words = ["-o", "runs", "--workers", "2", "--renderer", "cpu", "--quiet"]
    assert main(["track", *names, *words]) == 130
    assert "what was done is kept in runs" in capsys.readouterr().err
    states = [row.split(",")[2] for row in Path("runs", TABLE).read_text().splitlines()[1:]]
    assert states == 19 * ["done"] + ["waiting"]
    assert len(looked) == 20


def test_the_table_of_a_folder_that_is_a_link_leads_to_the_videos(tmp_path):
    (tmp_path / "deep" / "runs").mkdir(parents=True)
    (tmp_path / "runs").symlink_to(tmp_path / "deep" / "runs")
    Table(tmp_path / "runs", [job(tmp_path)]).write({})
    assert (tmp_path / "runs" / TABLE).read_text().splitlines()[1].startswith("a,../../a.mp4,")


def done_before(folder: Path, name: str, content: str) -> Path:
    """A folder of runs that holds one of a clip; the folder."""
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    (folder / name).write_text(content)
    runs = folder / "runs"
    (runs / "k").mkdir(parents=True)
    told = {"settings": {"video_sha256": digest(folder / name)}}
    (runs / "k" / "run.json").write_text(json.dumps(told))
    Table(runs, [Job(folder / name, runs / "k", "cpu", TrackOptions(), (), {})]).write({})
    return runs


@pytest.mark.parametrize("content", ["other", None])
def test_another_clip_of_the_name_of_a_run_leaves_the_files_about_all_clips(
    content, tmp_path, capsys
):
    runs = done_before(tmp_path, "s1/k.mp4", "one")
    before, other = contents(runs), tmp_path / "s2" / "k.mp4"
    if content:
        other.parent.mkdir()
        other.write_text(content)
    assert main(["track", str(other), "-o", str(runs), "--workers", "1", "--renderer", "cpu"]) == 2
    assert f"{runs / 'k'} is of {tmp_path / 's1/k.mp4'}; track {other}" in capsys.readouterr().err
    assert contents(runs) == before


def test_the_clip_of_a_run_may_have_been_moved(tmp_path):
    runs = done_before(tmp_path, "s1/k.mp4", "one")
    moved = (tmp_path / "s1" / "k.mp4").rename(tmp_path / "k.mp4")
    assert not rows_of_others(runs, [Job(moved, runs / "k", "cpu", TrackOptions(), (), {})])


def test_a_table_that_does_not_fit_leaves_the_one_before(tmp_path):
    (tmp_path / "runs").mkdir()
    Table(tmp_path / "runs", [job(tmp_path)]).write({})
    before = contents(tmp_path / "runs")
    with full(2000), pytest.raises(OSError, match="too large"):
        Table(tmp_path / "runs", [job(tmp_path, f"{k:099d}") for k in range(100)]).write({})
    assert contents(tmp_path / "runs") == before


@pytest.mark.parametrize(
    "table",
    [b"", b"\xff\xfe", b"a,b\n1,2\n", b"clip,video,status,frames,found,closed,message\n1,2\n"],
)
def test_a_table_that_is_none_is_written_anew(table, tmp_path):
    (tmp_path / TABLE).write_bytes(table)
    assert rows_of_others(tmp_path, [job(tmp_path)]) == []
    assert rows_of_others(tmp_path / "none", [job(tmp_path)]) == []


def test_a_folder_of_something_else_is_refused(tmp_path):
    (tmp_path / "results.csv").touch()
    with pytest.raises(OutputError, match="exists already"), runs_folder(tmp_path):
        pass


def test_a_folder_whose_table_was_removed_is_taken(tmp_path):
    (tmp_path / "timing.json").touch()  # as Snakemake leaves it, when there are more clips
    (tmp_path / "a").mkdir()
    with runs_folder(tmp_path) as folder:
        assert folder == tmp_path


def test_one_command_at_a_time_works_in_a_folder(tmp_path):
    with (
        runs_folder(tmp_path / "runs") as folder,
        pytest.raises(OutputError, match="another process"),
        runs_folder(folder),
    ):
        pass


def killed(allowed: int) -> SimpleNamespace:
    """What is left of a task whose workers died, one more than was allowed."""
    error = KilledWorker("a", SimpleNamespace(address="tcp://a"), allowed)
    return SimpleNamespace(status="error", exception=lambda: error)


@pytest.mark.parametrize("allowed", [0, DEATHS - 1])
def test_a_clip_that_kills_its_workers_is_given_up(allowed, tmp_path):
    watched, deaths = _Watched(job(tmp_path)), Counter()
    ends = [_outcome(killed(allowed), watched, deaths) for _ in range(GIVEN_UP // (allowed + 1))]
    assert ends[:-1] == [None] * (len(ends) - 1)
    assert ends[-1].status == FAILED
    assert "died 20 times" in ends[-1].message
    assert deaths == {"a": GIVEN_UP}


@pytest.mark.parametrize("allowed", [0, DEATHS - 1])
def test_a_clip_that_gets_on_is_never_given_up(allowed, tmp_path):
    watched, deaths = _Watched(job(tmp_path)), Counter()
    partial_of(watched.job.folder).mkdir(parents=True)
    for _ in range(3 * GIVEN_UP):
        with (partial_of(watched.job.folder) / FRAMES).open("ab") as file:
            file.write(b"frame")
        assert _outcome(killed(allowed), watched, deaths) is None
        assert watched.deaths < DEATHS


class Task:
    """What a scheduler gives for a task: done, or killed with its worker."""

    def __init__(self, dies: bool) -> None:
        self.status = "error" if dies else "finished"

    def result(self) -> Outcome:
        return Outcome("done")

    def exception(self) -> Exception:
        return killed(0).exception()

    def release(self) -> None:
        """Nothing is held."""


class Scheduler:
    """Two workers, of which one dies at a clip as often as is said, one task after the other."""

    cluster = None

    def __init__(self, dies: dict[str, int]) -> None:
        self.left, self.open, self.begun = Counter(dies), {}, []

    def nthreads(self) -> dict[str, int]:
        return {"one": 1, "other": 1}

    def submit(self, _function: object, given: Job, **_: object) -> Task:
        task = Task(self.left[given.name] > 0)
        self.left[given.name] -= 1
        self.open[task] = given.name
        self.begun.append(sorted(self.open.values()))
        return task

    def wait(self, tasks: list[Task], **_: object) -> SimpleNamespace:
        del self.open[tasks[0]]
        return SimpleNamespace(done={tasks[0]})


def ends_with(monkeypatch, folder: Path, dies: dict[str, int]) -> tuple[Scheduler, dict, Counter]:
    """Outcomes of clips a to e in the order of their ends, where workers die so often."""
    scheduler, deaths = Scheduler(dies), Counter()
    monkeypatch.setattr("distributed.wait", scheduler.wait)
    ended = track_many(scheduler, [job(folder, name) for name in "abcde"], deaths)
    return scheduler, {one.name: outcome for one, outcome in ended}, deaths


@pytest.mark.parametrize("dies", [DEATHS, GIVEN_UP - 1])
def test_a_clip_whose_workers_are_stopped_is_tried_again_after_the_others(
    dies, tmp_path, monkeypatch
):
    scheduler, found, deaths = ends_with(monkeypatch, tmp_path, {"a": dies, "c": 1})
    assert {outcome.status for outcome in found.values()} == {"done"}
    assert list(found)[-1] == "a"
    assert deaths == {"a": dies, "c": 1}
    assert scheduler.begun[DEATHS - dies - 1 :] == [["a"]] * (dies + 1 - DEATHS)


def test_clips_that_are_set_aside_have_the_machine_to_themselves(tmp_path, monkeypatch):
    scheduler, found, _ = ends_with(monkeypatch, tmp_path, {"a": 6, "b": GIVEN_UP, "d": 2})
    assert [name for name, outcome in found.items() if outcome.status == FAILED] == ["b"]
    assert set(list(found)[:3]) == {"c", "d", "e"}
    last = scheduler.begun[-(GIVEN_UP - DEATHS) :]
    assert all(len(running) == 1 for running in last)


def test_tasks_of_clips_whose_names_are_no_utf_8_can_be_sent(tmp_path, monkeypatch):
    sent = []

    class Sending(Scheduler):
        def submit(self, function: object, given: Job, *, key: str, **more: object) -> Task:
            sent.append(key.encode("utf-8"))
            return super().submit(function, given, **more)

    scheduler = Sending({})
    monkeypatch.setattr("distributed.wait", scheduler.wait)
    jobs = [job(tmp_path, name) for name in ("\udcff", r"\udcff")]
    assert len(list(track_many(scheduler, jobs, Counter()))) == len(set(sent)) == 2


@pytest.mark.parametrize("error", [CancelledError("connection lost"), OSError("timed out")])
def test_a_scheduler_that_goes_away_is_said_to_be_gone(error, tmp_path, monkeypatch):
    def lost(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr("distributed.wait", lost)
    with pytest.raises(ParameterError, match="the scheduler is gone; start one; the same command"):
        list(track_many(Scheduler({}), [job(tmp_path)], Counter()))


def test_a_worker_that_dask_has_given_up_is_replaced():
    with (
        LocalCluster(n_workers=1, processes=False, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        client.sync(cluster.workers[0].close)
        wait_until(lambda: not client.nthreads())
        replace_lost(client)
        wait_until(lambda: len(client.nthreads()) == 1)
        replace_lost(client)
        assert len(client.nthreads()) == len(cluster.workers) == 1


def wait_until(true: Callable[[], bool], seconds: float = 20.0) -> None:
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end
        time.sleep(0.05)


def test_a_fault_of_ours_is_reported_as_it_is(tmp_path):
    future = SimpleNamespace(status="error", exception=lambda: IndexError("of a\nlist"))
    outcome = _outcome(future, _Watched(job(tmp_path)), Counter())
    assert outcome == Outcome(FAILED, "IndexError: of a list")


def test_the_traceback_of_a_fault_of_ours_is_kept_until_the_next_try(tmp_path, monkeypatch):
    def faulty(*_, **__):
        return {}["lips"]

    monkeypatch.setattr("abs_engine.clips.worker.keep_to_one_core", lambda: None)
    monkeypatch.setattr("abs_engine.clips.worker.track_video", faulty)
    (tmp_path / "runs").mkdir()
    outcome = track_job(job(tmp_path))
    assert outcome == Outcome(FAILED, "KeyError: 'lips'; see a.traceback.txt in the folder of runs")
    kept = tmp_path / "runs" / "a.traceback.txt"
    assert 'return {}["lips"]' in kept.read_text()
    done = {"summary": {"frames": 1, "lost_frames": 0, "closed_frames": 0}}
    monkeypatch.setattr("abs_engine.clips.worker.track_video", lambda *_, **__: done)
    assert track_job(job(tmp_path)).status == "done"
    assert not kept.exists()


def test_a_fault_whose_traceback_cannot_be_kept_is_still_reported(tmp_path, monkeypatch):
    monkeypatch.setattr("abs_engine.clips.worker.keep_to_one_core", lambda: None)
    monkeypatch.setattr("abs_engine.clips.worker.track_video", lambda *_, **__: {}["lips"])
    assert track_job(job(tmp_path)) == Outcome(FAILED, "KeyError: 'lips'")  # no such folder


def test_a_worker_reports_a_clip_that_is_not_there(tmp_path, monkeypatch):
    monkeypatch.setattr("abs_engine.clips.worker.keep_to_one_core", lambda: None)
    outcome = track_job(job(tmp_path))
    assert outcome.status == FAILED
    assert str(tmp_path / "a.mp4") in outcome.message


def contents(folder: Path) -> dict[str, bytes]:
    files = (path for path in folder.rglob("*") if path.is_file() and path.name != "timing.json")
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


@pytest.fixture(scope="module")
def tracked(tmp_path_factory):
    """Two clips, one of them no video, tracked by two workers of a local cluster."""
    folder = tmp_path_factory.mktemp("clips")
    pictures = [
        lit("amara", seen_at([0, 0.03 * k, 0], [0, 0, 700]), jawOpen=amount)
        for k, amount in enumerate(OPEN)
    ]
    write_kind(folder / "head.mp4", "libx264", pictures)
    (folder / "text.mp4").write_text("no video")
    words = [str(folder / name) for name in ("head.mp4", "text.mp4")]
    words = ["track", *words, "-o", str(folder / "runs"), "--renderer", "cpu", "--quiet"]
    words += ["--smooth", "savitzky-golay:5"]
    assert main([*words, "--workers", "2"]) == 2
    return folder, words


@pytest.fixture
def in_threads(monkeypatch):
    """Workers in this process, where no clip is tracked: a process takes seconds to begin."""
    monkeypatch.setattr("distributed.LocalCluster", Threads)
    monkeypatch.setattr("abs_engine.clips.worker.keep_to_one_core", lambda: None)


@pytest.mark.usefixtures("in_threads")
def test_the_files_about_all_clips_keep_those_of_an_earlier_command(tmp_path):
    folder = tmp_path / "runs"
    for names in ("ab", "c", "a"):
        videos = [tmp_path / f"{name}.mp4" for name in names]
        for video in videos:
            video.write_text("no video")
        words = ["track", *videos, "-o", folder, "--renderer", "cpu", "--workers", "1", "--quiet"]
        assert main([str(word) for word in words]) == 2
    with (folder / TABLE).open(newline="") as file:
        assert [(row["clip"], row["status"]) for row in csv.DictReader(file)] == [
            ("b", "failed"), ("c", "failed"), ("a", "failed")
        ]  # fmt: skip
    assert list(json.loads((folder / "timing.json").read_text())["clips"]) == ["a", "b", "c"]
    for name in (TABLE, "timing.json"):
        (folder / name).write_text("{")
    assert main([str(word) for word in words]) == 2
    assert len((folder / TABLE).read_text().splitlines()) == 2
    assert list(json.loads((folder / "timing.json").read_text())["clips"]) == ["a"]


@pytest.mark.usefixtures("in_threads")
def test_a_folder_of_runs_that_takes_nothing_is_named(tmp_path, monkeypatch, capsys):
    def refuse(path: Path, **_: object) -> None:
        if path != runs:
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    runs = tmp_path / "runs"
    runs.mkdir()
    monkeypatch.setattr(Path, "mkdir", refuse)
    assert main(["track", "a.mp4", "-o", str(runs), "--workers", "1", "--renderer", "cpu"]) == 2
    assert f"{runs} cannot be written (Permission denied)" in capsys.readouterr().err


@pytest.mark.parametrize("again", [False, True])
def test_an_interrupt_while_workers_start_promises_what_is_there(
    again, tmp_path, monkeypatch, capsys
):
    def interrupted(**_: object) -> None:
        raise KeyboardInterrupt

    runs, left = tmp_path / "runs", []
    if again:
        runs.mkdir()
        Table(runs, [job(tmp_path)]).write({})
    monkeypatch.setattr("distributed.LocalCluster", interrupted)
    monkeypatch.setattr("atexit.unregister", left.append)
    monkeypatch.setattr(logging.getLogger("asyncio"), "setLevel", left.append)
    words = ["-o", str(runs), "--workers", "1", "--renderer", "cpu", "--quiet"]
    assert main(["track", "a.mp4", *words]) == 130
    kept = f"; what was done is kept in {runs}; the same command resumes there" if again else ""
    assert capsys.readouterr().err.splitlines()[-1] == f"abs-engine: interrupted{kept}"
    assert runs.exists() == again
    assert left == [close_clusters, logging.CRITICAL]


PROCESSES = """
import sys
from pathlib import Path
import psutil
from abs_engine.clips.cluster import local_workers
with local_workers(1, Path(sys.argv[1])):
    for process in psutil.Process().children(recursive=True):
        lines = Path(f"/proc/{process.pid}/status").read_text().splitlines()
        status = dict(line.split(":", 1) for line in lines)
        print(int(status["SigBlk"], 16) | int(status["SigIgn"], 16))
"""


def test_processes_of_workers_leave_ctrl_c_and_a_closed_terminal_to_the_command(tmp_path):
    words = [sys.executable, "-c", PROCESSES, str(tmp_path)]
    heedless = list(map(int, subprocess.check_output(words, text=True).split()))
    assert len(heedless) >= 2  # the worker, and multiprocessing's tracker of resources
    for number in signal.SIGINT, signal.SIGHUP:
        assert all(mask >> (number - 1) & 1 for mask in heedless)


@pytest.mark.slow
def test_a_clip_that_fails_stops_no_other(tracked):
    folder, _ = tracked
    with (folder / "runs" / TABLE).open(newline="") as file:
        head, text = csv.DictReader(file)
    assert (head["status"], head["frames"], head["found"]) == ("done", "5", "5")
    assert text["status"] == "failed"
    assert "text.mp4" in text["message"]
    assert {p.name for p in (folder / "runs").iterdir()} == {"head", TABLE, "timing.json"}


@pytest.mark.slow
def test_a_run_is_that_of_its_clip_alone(tracked):
    folder, _ = tracked
    alone = ["track", str(folder / "head.mp4"), "-o", str(folder / "runs-head"), "--quiet"]
    assert main([*alone, "--renderer", "cpu", "--smooth", "savitzky-golay:5"]) == 0
    ours, other = contents(folder / "runs" / "head"), contents(folder / "runs-head")
    paths = [json.loads(one.pop("run.json")) for one in (ours, other)]
    assert [one["settings"].pop("video_path") for one in paths] == ["../../head.mp4", "../head.mp4"]
    assert paths[0] == paths[1]
    assert ours == other


@pytest.mark.slow
def test_smoothing_is_named_in_the_run_and_lies_beside_what_was_found(tracked):
    folder = tracked[0] / "runs" / "head"
    told = json.loads((folder / "run.json").read_text())["settings"]["smoothing"]
    assert told == {"filter": "savitzky-golay", "window_frames": 5, "degree": 2}
    names = "results.csv", "smoothed.csv"
    raw, smooth = (list(csv.DictReader((folder / n).read_text().splitlines())) for n in names)
    assert len(raw) == len(smooth) == len(OPEN)
    before, after = (np.array([float(row["aperture"]) for row in rows]) for rows in (raw, smooth))
    parabola = np.polynomial.Polynomial.fit(np.arange(len(OPEN)), before, 2)
    np.testing.assert_allclose(after, parabola(np.arange(len(OPEN))).clip(0), atol=1e-3)


def test_pictures_are_said_to_be_clips_of_their_own(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("abs_engine.cli.commands.track.track_clips", lambda *_: Done([], {"a": 1}))
    line = "each picture is tracked as a clip of its own"
    assert main(["track", "a.png", "b.PNG", "-o", str(tmp_path / "runs")]) == 0
    assert line in capsys.readouterr().out
    assert main(["track", "a.png", "b.mp4", "-o", str(tmp_path / "runs")]) == 0
    assert line not in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.usefixtures("in_threads")
def test_other_options_for_the_same_folder_leave_its_table_as_it_was(tracked, capsys):
    folder, words = tracked
    before = contents(folder / "runs")
    assert main([*words, "--workers", "1", "--driver", "simplex"]) == 2
    said = capsys.readouterr().err
    assert "head was tracked with other options" in said
    assert contents(folder / "runs") == before


@pytest.mark.slow
@pytest.mark.usefixtures("in_threads")
def test_the_same_again_keeps_runs_that_were_moved_but_not_as_those_of_another_clip(
    tracked, tmp_path, capsys
):
    folder, words = tracked
    moved = tmp_path / "moved"
    shutil.copytree(folder, moved)
    words = [word.replace(str(folder), str(moved)) for word in words]
    before, made = contents(moved / "runs"), (moved / "runs" / "head").stat().st_mtime_ns
    table = before[TABLE].replace(bytes(folder), bytes(moved))  # the message names the video
    assert main([*words, "--workers", "1"]) == 2
    said = capsys.readouterr().out.splitlines()
    assert said[0].startswith("failed: text: ")
    assert said[1].startswith("1 of 2 clips done")
    assert contents(moved / "runs") == before | {TABLE: table}
    assert (moved / "runs" / "head").stat().st_mtime_ns == made
    pictures = [lit("mei", seen_at([0, 0, 0], [0, 0, 700]))] * 5
    write_kind(moved / "head.mp4", "libx264", pictures)
    before = contents(moved / "runs" / "head")
    assert main([*words, "--workers", "1"]) == 2
    said = capsys.readouterr().out.splitlines()
    assert "head exists already, made of other input" in said[0]
    assert said[2] == f"0 of 2 clips done; wrote {moved / 'runs' / TABLE}"
    assert contents(moved / "runs" / "head") == before


def test_options_are_the_same_where_only_the_paths_of_their_files_changed(tmp_path):
    (tmp_path / "runs" / "a").mkdir(parents=True)
    (tmp_path / "runs" / "a" / "settings.toml").write_text('camera = "../../c.json"\nface = 1\n')

    def asked(settings: str) -> Job:
        return replace(job(tmp_path), beside={"settings.toml": settings})

    check_same_options(asked('camera = "../../../c.json"\nface = 1\n'))
    for other in ('camera = "../../c.json"\nface = 2\n', "face = 1\n"):
        with pytest.raises(OutputError, match="was tracked with other options"):
            check_same_options(asked(other))


def test_another_release_is_named_and_a_comment_about_it_is_no_other_option(tmp_path):
    run = tmp_path / "runs" / "a"
    run.mkdir(parents=True)
    (run / "settings.toml").write_text("# abs-engine 0.0.1: track\nface = 1\n")
    asked = replace(job(tmp_path), beside={"settings.toml": "# abs-engine 9: track\nface = 1\n"})
    check_same_options(asked)
    (run / "timing.json").write_text("{}")
    (run / "run.json").write_text(json.dumps({"engine_version": engine_version()}))
    check_same_options(asked)
    (run / "run.json").write_text('{"engine_version": "0.0.1"}')
    with pytest.raises(OutputError, match=r"was tracked by abs-engine 0\.0\.1, and this is"):
        check_same_options(asked)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--workers", "2", "--scheduler", "tcp://127.0.0.1:1"], "leave out --workers"),
        (["--workers", "2", "--terms", "color"], "did you mean 'colour'"),
        (["--workers", "0"], "not 1 or more"),
    ],
)
def test_what_cannot_be_is_refused_before_anything_is_made(more, said, tmp_path, capsys):
    assert main(["track", "a.mp4", "-o", str(tmp_path / "runs"), *more]) == 2
    assert said in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_scheduler_that_does_not_answer_leaves_nothing(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr("abs_engine.clips.cluster._ANSWER", "1s")
    words = ["--scheduler", "tcp://127.0.0.1:1"]
    assert main(["track", "a.mp4", "-o", str(tmp_path / "runs"), *words]) == 2
    assert "no scheduler answers at tcp://127.0.0.1:1" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_clips_that_lost_frames_or_have_warnings_are_named_and_others_not():
    outcomes = {
        "a": Outcome("done", frames=10, found=10, closed=2),
        "b": Outcome("done", "look at the overlay | no colour | small", 10, 10, 0),
        "c": Outcome("done", frames=10, found=7, closed=0),
    }
    assert list(_doubtful(outcomes)) == [
        "b: warning: look at the overlay (and 2 more)", "c: 3 of 10 frames lost",
    ]  # fmt: skip
    many = {f"{k:02d}": Outcome("done", frames=2, found=1) for k in range(25)}
    lines = list(_doubtful(many))
    assert lines[0] == "00: 1 of 2 frames lost"
    assert lines[20:] == ["and 5 more clips with lost frames or warnings"]
