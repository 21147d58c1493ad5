"""Scenes filmed whole: several cameras and processes, and what happens when it is interrupted.

Chunks are of 20 frames, that a clip of 24 has two of them; in the processes that film as well.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from abs_engine.cli import main
from abs_engine.core.clock import Clock, cost_lines
from abs_engine.core.errors import InputFileError, OutputError, StudioError
from abs_engine.dataset import card, codec, load_dataset, offsets
from abs_engine.evaluate.check import check_dataset
from abs_engine.io import naming
from abs_engine.io.naming import partial_of
from abs_engine.studio import chunk, filming, make
from abs_engine.studio.chunk import Job, jobs_of
from abs_engine.studio.journal import Journal
from abs_engine.studio.make import Crew
from abs_engine.studio.plan import load
from abs_engine.studio.pool import _next
from abs_engine.studio.scenefile import parse_scene, read_scene

ROOT = Path(__file__).parents[2]
SCENE = """
format = "abs_engine.scene"
version = 1
seed = 5
rate = 25
size = [96, 72]
frames = true
[[camera]]
name = "front"
focal = 160
[[camera]]
name = "glass"
position = [60, 30, 700]
target = [60, 0, 60]
focal = 126
distortion = [-0.2, 0.08]
mirror = { centre = [190, 0, 640], yaw_degrees = -50, size = [260, 300] }
sensor = { bands = 4 }
[[occluder]]
kind = "microphone"
start = 0.1
end = 0.8
travel = 0.2
[[event]]
kind = "leave"
start = 0.8
end = 2.3
direction = [-1, 0, 0]
cameras = ["front"]
[[clip]]
name = "say"
speaker = "kofi"
say = "_ m A: p a _"
frames = 24
cameras = ["front"]
[[clip]]
name = "two"
sentence = "demo"
frames = 4
"""

FEW = 20
SHORTEN = f"""
import sys
if not sys.orig_argv[-1].endswith("worker.py"):  # which draws, and knows no chunks
    from abs_engine.dataset import card, codec, offsets
    from abs_engine.studio import chunk, make
    for module in (card, codec, offsets, chunk, make):
        module.CHUNK = {FEW}
"""
"""Executed by every Python process before all else."""


@pytest.fixture(scope="module", autouse=True)
def short_chunks(tmp_path_factory):
    """A fifth of the usual frames in a chunk, here and in processes that are started here."""
    folder = tmp_path_factory.mktemp("site")
    (folder / "sitecustomize.py").write_text(SHORTEN)
    with pytest.MonkeyPatch.context() as patch:
        for module in (card, codec, offsets, chunk, make):
            patch.setattr(module, "CHUNK", FEW)
        patch.setenv("PYTHONPATH", str(ROOT), prepend=os.pathsep)
        patch.setenv("PYTHONPATH", str(folder), prepend=os.pathsep)
        yield


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    """Filmed by two processes."""
    folder = tmp_path_factory.mktemp("scene") / "data"
    done = filming.film_scene(parse_scene(SCENE), folder, command="it", crew=Crew(2))
    assert (done.folder, done.frames, done.resumed) == (folder, 32, 0)
    assert {"draw", "png", "labels", "video"} <= set(done.seconds)
    assert [p.name for p in folder.parent.iterdir()] == ["data"]
    return folder


def test_every_clip_and_camera_is_there(dataset):
    data = load_dataset(dataset, verify=True)
    assert len(list((dataset / "say" / codec.VERTICES).iterdir())) == 2
    assert data.views == (("say", "front"), ("two", "front"), ("two", "glass"))
    assert parse_scene((dataset / "scene.toml").read_text()).clip[0].name == "say"
    cost = json.loads((dataset / "timing.json").read_text())["milliseconds_per_frame"]
    assert cost["draw"] > 1
    for truth in data:
        assert len(list(truth.pictures())) == len(truth)
        assert {p.name for p in truth.folder.iterdir() if p.is_dir()} == {
            *("ids", "depth", "normals", "albedo", "flow", "frames", "cover")
        }


def test_what_stands_before_the_mouth_hides_it(dataset):
    truth = load_dataset(dataset).view("say", "front")
    lips = [56, 57, 58]  # the lower one
    assert truth.landmark_visible[0][lips].all()
    assert not (truth.cover(0) == 2).any()
    assert not truth.landmark_visible[12][lips].any()
    covered = truth.cover(12) == 2
    assert covered.sum() > 100
    assert (truth.facet_ids(12)[covered] == 0).all()
    assert truth.in_picture[12]
    assert not truth.flow(23)[1].any()


def test_a_mirror_shows_the_head_twice(dataset):
    truth = load_dataset(dataset).view("two", "glass")
    assert truth.mirror.shape == (4, 3)
    left, right = truth.facet_ids(0)[:, :48], truth.facet_ids(0)[:, 60:]
    assert (left > 0).sum() > 200
    assert (right > 0).sum() > 100
    near, far = truth.depth(0)[:, :48], truth.depth(0)[:, 60:]
    assert np.median(far[far > 0]) > np.median(near[near > 0]) + 100


def test_the_checker_finds_nothing(dataset):
    assert [str(finding) for finding in check_dataset(dataset, frames=10)] == []


def test_interrupted_and_given_again_it_goes_on_to_the_same_pixels_as_with_two_processes(
    dataset, tmp_path, capsys
):
    (tmp_path / "s.toml").write_text(SCENE)
    words = ["synth", str(tmp_path / "s.toml"), "-o", str(tmp_path / "data"), "--processes", "1"]
    heed = "signal.signal(signal.SIGINT, signal.default_int_handler)"  # a shell's & ignores it
    code = f"import signal, sys; from abs_engine.cli import main; {heed}; sys.exit(main({words}))"
    running = subprocess.Popen(
        [sys.executable, "-c", code], cwd=ROOT, stderr=subprocess.PIPE, text=True
    )
    work = partial_of(tmp_path / "data")
    first = work / "chunks" / Job(0, 0, 0).name
    deadline = time.monotonic() + 60
    while not first.exists() and time.monotonic() < deadline:
        time.sleep(0.02)
    running.send_signal(signal.SIGINT)
    _, said = running.communicate(timeout=30)
    assert running.returncode == 130
    assert f"kept in {work}; the same command resumes" in said.strip().splitlines()[-1]
    before = first.stat().st_mtime_ns
    with pytest.raises(OutputError, match="another scene"):
        filming.film_scene(parse_scene(SCENE.replace("seed = 5", "seed = 6")), tmp_path / "data")
    assert first.stat().st_mtime_ns == before
    assert main(words) == 0
    assert "20 of 32 frames were there from before" in capsys.readouterr().out
    assert sorted(p.name for p in tmp_path.iterdir()) == ["data", "s.toml"]
    same_files(dataset, tmp_path / "data")


def test_what_counts_as_done_was_on_the_disk_before(tmp_path, monkeypatch):
    """A power cut leaves no chunk, plan or video that is taken for whole and is not."""
    settled, too_soon, named = set(), [], []
    sync = os.fsync

    def synced(number):
        settled.add(Path(os.readlink(f"/proc/self/fd/{number}")))
        sync(number)

    def watched(rename):
        def first(made, place):
            named.append(place.name)
            needed = [made]
            if place.parent.name == "chunks":
                needed += (p for p in (place.parents[1] / "whole").rglob("*.*") if p.is_file())
            too_soon.extend(set(needed) - settled)
            rename(made, place)

        return first

    monkeypatch.setattr(os, "fsync", synced)
    monkeypatch.setattr(os, "replace", watched(os.replace))
    monkeypatch.setattr(naming, "_rename_only", watched(naming._rename_only))
    scene = parse_scene(SCENE.replace("frames = 24", "frames = 3"))
    filming.film_scene(scene, tmp_path / "data", crew=Crew(1))
    assert {Job(0, 0, 0).name, "00000.npz", codec.VIDEO, "data"} <= set(named)
    assert not too_soon


def same_files(first, second):
    """All but what it cost, the command, and their checksums."""
    names = sorted(p.relative_to(first) for p in first.rglob("*") if p.is_file())
    assert names == sorted(p.relative_to(second) for p in second.rglob("*") if p.is_file())
    for name in names:
        costs = name.name in ("dataset.json", "timing.json")
        if name.suffix in (".png", ".toml", ".json", ".mp4") and not costs:
            assert (first / name).read_bytes() == (second / name).read_bytes(), name
        if name.suffix == ".npz":
            a, b = np.load(first / name), np.load(second / name)
            assert all((a[k] == b[k]).all() for k in a.files if k != "command"), name


def test_two_at_once_at_one_data_set(tmp_path):
    busy = pytest.raises(OutputError, match="another process makes")
    with Journal(tmp_path / "data", "scene"), busy:
        Journal(tmp_path / "data", "scene")
    (partial_of(tmp_path / "data") / "chunks" / "x.npz").write_text("")
    with Journal(tmp_path / "data", "scene") as again:
        assert again.resumed
        assert again.done("x.npz")
    with Journal(tmp_path / "data", "") as anew:  # of no scene: nothing to go on from
        assert not anew.resumed
        assert not anew.done("x.npz")


def test_what_a_crash_left_in_pieces_is_to_be_removed(tmp_path):
    with Journal(tmp_path / "data", "scene") as journal:
        journal.plan(0).write_bytes(b"PK")
    said = pytest.raises(InputFileError, match=rf"remove {journal.partial} to begin again")
    with said, Journal(tmp_path / "data", "scene") as again:
        load(again.plan(0))
    assert journal.plan(0).is_file()


def test_a_film_process_that_dies_is_one_line(tmp_path):
    killed = []

    def kill(_done, _all_frames):
        if not killed:
            listing = subprocess.run(
                ["ps", "-ww", "--ppid", str(os.getpid()), "-o", "pid=,args="],
                capture_output=True, text=True, check=True,
            ).stdout  # fmt: skip
            films = [line.split() for line in listing.splitlines() if "film_process" in line]
            killed.append(int(films[0][0]))
            os.kill(killed[0], signal.SIGKILL)

    with pytest.raises(StudioError, match="a film process ended") as caught:
        filming.film_scene(
            parse_scene(SCENE), tmp_path / "data", crew=Crew(2, keep=True, filming=kill)
        )
    assert "\n" not in str(caught.value)
    assert killed
    for left in tmp_path.iterdir():  # what the other process had done by then is kept
        assert left == partial_of(tmp_path / "data")
        assert list((left / "chunks").iterdir())


def test_jobs_are_chunks_and_each_process_stays_with_its_camera():
    jobs = jobs_of([(FEW * 5 // 2, 2), (FEW, 1)])
    assert len(jobs) == 7
    assert [job.chunk for job in jobs] == [0, 1, 2, 0, 1, 2, 0]

    class Film:
        job = None

    a, b = Film(), Film()
    order = []
    for film in (a, b, a, b, a, b, a):
        film.job = _next(jobs, film, [a, b])
        order.append((film.job.clip, film.job.view, film.job.chunk))
    assert order[:6] == [(0, 0, 0), (0, 1, 0), (0, 0, 1), (0, 1, 1), (0, 0, 2), (0, 1, 2)]
    assert not jobs


def test_the_clock_adds_up():
    clock = Clock()
    with clock.part("a"):
        begun = time.process_time()
        while time.process_time() < begun + 0.01:
            pass
    with clock.part("b"):
        time.sleep(0.05)
    assert clock.seconds["a"] >= 0.01 > clock.seconds["b"]  # waiting costs nothing
    lines = cost_lines({"draw": 3.0, "png": 1.0}, 100)
    words = [line.split()[:2] for line in lines]
    assert words == [["draw", "30.0"], ["png", "10.0"], ["all", "40.0"]]


def test_every_p_b_and_m_of_the_shipped_speech_is_a_contact():
    """The plan's own mesh: what is filmed is neutral + offsets of these weights."""
    from abs_engine.dataset.codec import CLOSED_BELOW
    from abs_engine.io.assets import load_speaker
    from abs_engine.studio.cast import Cast
    from abs_engine.studio.people.lip_contact import widest_gap
    from abs_engine.studio.resolve import plan_clip
    from abs_engine.studio.scenefile import complete
    from abs_engine.studio.sequence import deform

    speaker = load_speaker()
    scene = complete(read_scene(ROOT / "assets" / "scenes" / "speech.toml"))
    plan = plan_clip(scene, 0, speaker, Cast(speaker, scene.speaker), ROOT, "")
    bilabials = [i for i in plan.intervals if i[0] in "pbm"]
    assert len(bilabials) > 15
    for label, start, end in bilabials:
        frames = [f for f in range(len(plan)) if start <= f / plan.rate < end]
        gaps = [
            widest_gap(speaker, plan.neutral + deform(speaker, plan.weights[f])) for f in frames
        ]
        assert min(gaps) < CLOSED_BELOW, (label, start)
