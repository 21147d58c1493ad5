"""The benchmark's structure, and that all its ways do the same work; no times are judged."""

from __future__ import annotations

import json
from itertools import islice

import numpy as np
import pytest
from conftest import missing

from abs_engine.core.errors import OpenGLError, ParameterError
from abs_engine.evaluate import bench_ways
from abs_engine.evaluate.bench import run_bench
from abs_engine.evaluate.bench_clip import BenchError, bench_clip
from abs_engine.evaluate.bench_result import RATIOS, WAYS, BenchResult
from abs_engine.evaluate.bench_ways import PyrenderWorker, WorkerError
from abs_engine.evaluate.bench_work import N_CANDIDATES, ball_work
from abs_engine.io.video import VideoWriter, read_frames

GL_WAYS = ("gl_thin", "gl_instanced", "gl_batched")
PYRENDER_WAYS = ("pyrender_numpy", "pyrender_tuned")
FEW = 10
"""Frames of a real clip that are timed."""


@pytest.fixture(scope="module")
def result() -> BenchResult:
    return run_bench(rounds=2, sizes=((3, 64),))


def refuse(*_, **__):
    raise OpenGLError("nothing draws", "install something")


def refuse_worker(*_):
    raise WorkerError("no pyrender")


def test_layout(result):
    saved = json.loads(json.dumps(result.as_json(), allow_nan=False))
    assert (saved["format"], saved["version"], saved["rounds"]) == ("abs_engine.bench", 1, 2)
    assert list(saved["works"]) == ["1280x64"]
    work = saved["works"]["1280x64"]
    assert set(work["ms"]) == set(work["best_ms"]) == set(work["difference"]) == set(WAYS)
    assert work["ms"]["cpu"] >= work["best_ms"]["cpu"] > 0
    assert saved["machine"]["cores"] >= 1
    assert saved["machine"]["numpy"] == np.__version__
    assert set(saved["renderers"]) == {way for way in WAYS if work["ms"][way] is not None}


def test_ratios_are_those_of_the_times(result):
    work = result.works[0]
    for name, (way, against) in RATIOS.items():
        mine = work.ms[work.gl_way if way == "gl" else way]
        theirs = work.ms[against]
        if mine is None or theirs is None:
            assert work.ratios[name] is None
        else:
            assert work.ratios[name] == pytest.approx(theirs / mine)


def test_lines(result):
    lines = result.as_lines()
    assert all(any(line.split()[0] == way for line in lines) for way in WAYS)
    assert any(result.machine["cpu"] in line for line in lines)
    assert max(len(line) for line in lines[:12]) < 80


def test_opengl_and_cpu_agree(result):
    difference = result.works[0].difference
    if difference["gl_thin"] is None:
        missing("OpenGL")
    assert max(difference[way] for way in GL_WAYS) < 1e-3


def test_pyrender_does_the_same_work(result):
    difference = result.works[0].difference
    if difference["pyrender_tuned"] is None:
        missing("pyrender")
    assert difference["pyrender_tuned"] < 0.06  # 8-bit colours, smoothed edges
    assert difference["pyrender_numpy"] < 0.15  # and a light


def test_what_is_missing_is_none_and_noted(monkeypatch):
    monkeypatch.setattr(bench_ways, "OpenGLRenderer", refuse)
    monkeypatch.setattr(bench_ways, "PyrenderWorker", refuse_worker)
    result = run_bench(rounds=1, sizes=((1, 16), (0, 8)))
    assert [work.name for work in result.works] == ["80x16", "20x8"]
    for work in result.works:
        assert work.ms["cpu"] > 0
        assert all(work.ms[way] is None for way in (*GL_WAYS, *PYRENDER_WAYS))
        assert set(work.ratios.values()) == {None}
    assert len(result.notes) == 2
    assert "nothing draws" in result.notes[0]
    assert "no pyrender" in result.notes[1]
    assert list(result.notes) == result.as_lines()[-2:]
    json.dumps(result.as_json(), allow_nan=False)


def test_a_worker_that_cannot_draw_says_why(monkeypatch):
    monkeypatch.setattr(bench_ways, "PLATFORMS", ("nonsense",))
    with pytest.raises(WorkerError, match="nonsense: "):
        PyrenderWorker(ball_work(0, 8))


def test_a_worker_that_ends_is_not_waited_for(result, monkeypatch):
    if result.works[0].ms["pyrender_tuned"] is None:
        missing("pyrender")

    class Mortal(PyrenderWorker):
        def run(self, way, count):
            if count != N_CANDIDATES:  # every request but the first of each way
                self._process.kill()
                self._process.wait()
            return super().run(way, count)

    monkeypatch.setattr(bench_ways, "PyrenderWorker", Mortal)
    broken = run_bench(rounds=1, sizes=((1, 16),))
    assert all(broken.works[0].ms[way] is None for way in PYRENDER_WAYS)
    assert any("broke off" in note for note in broken.notes)


def test_the_work_is_always_the_same():
    one, two = ball_work(1, 16).as_arrays(), ball_work(1, 16).as_arrays()
    assert all(np.array_equal(one[name], two[name]) for name in one)


def test_no_rounds_are_refused():
    with pytest.raises(ParameterError, match="rounds"):
        run_bench(rounds=0)


def test_a_peer_that_is_not_there_is_named_before_anything_slow(tmp_path):
    video = written(tmp_path / "clip.mp4")
    with pytest.raises(ParameterError, match="is not a file"):
        bench_clip(video, "cpu", tmp_path / "nowhere")
    plain = tmp_path / "python"
    plain.write_text("#!/bin/sh\necho no mediapipe >&2\nexit 1\n")
    plain.chmod(0o755)
    with pytest.raises(BenchError, match="MediaPipe does not run: no mediapipe"):
        bench_clip(video, "cpu", plain)


@pytest.mark.parametrize("says", ["", "echo no json"])
def test_a_peer_that_says_nothing_of_use(says, tmp_path):
    plain = tmp_path / "python"
    plain.write_text(f"#!/bin/sh\n{says}\n")
    plain.chmod(0o755)
    with pytest.raises(BenchError, match="ends without a result"):
        bench_clip(written(tmp_path / "clip.mp4"), "cpu", plain)


def test_a_clip_without_a_face_says_so(tmp_path):
    with pytest.raises(BenchError, match="no face was found"):
        bench_clip(written(tmp_path / "clip.mp4"), "cpu", None, turns=1)


def test_a_clip_is_timed_beside_a_peer(tmp_path, grid_clip, monkeypatch):
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")  # not passed on to either
    peer = tmp_path / "python"
    said = f'{{"frames": {FEW}, "seen": {FEW}, "version": "0.0\'$PYTHONDONTWRITEBYTECODE\'"}}'
    peer.write_text(f"#!/bin/sh\nsleep 0.2\necho '{said}'\n")
    peer.chmod(0o755)
    found = bench_clip(grid_clip, "cpu", peer, turns=1)
    told = json.loads(json.dumps(found.as_json(), allow_nan=False))
    assert told["ratio"] == pytest.approx(told["seconds"] / told["seconds_peer"])
    assert 0 < told["first_result_seconds"] < told["seconds"]
    assert told["fps"] > 0
    assert 0 < told["drawings_per_frame"] < 100
    assert {"reading", "head pose", "evidence", "fit", "overlay", "other"} <= set(told["parts"])
    assert any("frames/s" in line for line in found.as_lines())
    assert any("MediaPipe 0.0:" in line for line in found.as_lines())


def written(path):
    """A short clip that shows nothing."""
    with VideoWriter(path, (64, 48), 25.0) as writer:
        for _ in range(4):
            writer.write(np.zeros((48, 64, 3), np.uint8))
    return path


@pytest.fixture
def grid_clip(data_dir, tmp_path):
    """The beginning of a clip of a real speaker."""
    frames = read_frames(data_dir / "grid" / "bbaf2n.mpg")
    first = next(frames)
    with VideoWriter(tmp_path / "bbaf2n.mp4", first.shape[1::-1], 25.0) as writer:
        for frame in (first, *islice(frames, FEW - 1)):
            writer.write(frame)
    return tmp_path / "bbaf2n.mp4"
