"""A run that is cut off at any frame goes on there, and ends as if it had not been."""

from __future__ import annotations

import errno
import os
import tracemalloc

import numpy as np
import pytest
from drawn import film

from abs_engine.core.errors import OutputError, VideoError
from abs_engine.core.geometry import Pose
from abs_engine.fit.belief import Belief
from abs_engine.io.naming import partial_of
from abs_engine.io.unfinished import Unfinished
from abs_engine.render.cpu import CpuRenderer
from abs_engine.tracking.frame.clip_setting import FrameResult
from abs_engine.tracking.frame.frame_state import Memory
from abs_engine.tracking.results.frame_journal import FRAMES, FrameJournal, fingerprint
from abs_engine.tracking.run import DISCARDED, kept_if_of_use, track_video


def track(video, folder, until=None, error=None, stage=None, remark=None, **beside):
    """Track, or fail after so many frames."""

    def progress(done, _frames):
        if done == until:
            raise error

    asked = {"progress": progress, "stage": stage, "remark": remark, "beside": beside}
    return track_video(video, folder, CpuRenderer(), **asked)


def contents(folder):
    """The bytes of all files but what they took."""
    return {p.name: p.read_bytes() for p in folder.iterdir() if p.name != "timing.json"}


@pytest.mark.slow
@pytest.mark.usefixtures("soon_ready")
def test_cut_off_twice_it_ends_with_the_same_bytes_and_leaves_nothing_beside(tmp_path):
    video, folder = film(tmp_path / "head.mp4", frames=3, factor=0.5), tmp_path / "run"
    with pytest.raises(KeyboardInterrupt, match="the same command resumes"):
        track(video, folder, until=1, error=KeyboardInterrupt, note="another command")
    said = []
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    with pytest.raises(OutputError, match="No space left"):
        track(video, folder, until=2, error=full, remark=said.append)
    assert said == [DISCARDED]
    with (partial_of(folder) / FRAMES).open("ab") as journal:
        journal.write(b'1234abcd {"result": ')  # cut off within a line
    (partial_of(folder) / "whole" / "results.csv").write_text("half of a table")
    busy = []

    def other(_stage):
        with pytest.raises(OutputError, match="another process makes"):
            track(video, folder)
        busy.append(True)

    told = track(video, folder, stage=other, remark=said.append)
    assert busy
    assert said == [DISCARDED, "resuming: 2 frames already tracked"]
    assert told["timing"]["resumed_frames"] == 2
    assert track(video, tmp_path / "own")["timing"]["resumed_frames"] == 0
    assert contents(folder) == contents(tmp_path / "own")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["head.mp4", "own", "run"]


@pytest.mark.parametrize(
    ("error", "kept"),
    [(VideoError("it breaks off", "export it"), False), (MemoryError(), True)],
)
def test_what_the_same_command_cannot_go_on_with_is_not_kept(tmp_path, error, kept):
    def fail():
        with Unfinished(tmp_path / "run", "choices") as made:
            frames = made.partial / FRAMES
            with kept_if_of_use(made, frames):
                frames.touch()
                raise error

    with pytest.raises(type(error)):
        fail()
    assert any(tmp_path.iterdir()) == kept


def found(index):
    """A frame in which something was found, and one in which nothing was."""
    pose = Pose(np.eye(3), np.r_[0.1, 0.2, 500.0])
    sure = Belief(0.1, 0.2, 0.3, np.full((2, 3), 1 / 3), np.ones(3), np.ones(3), np.float64(0.7))
    lips = np.array([[1 / 3, np.pi, 1e-300], [np.nan, np.inf, -0.0]])
    result = FrameResult(
        index, np.True_, np.arange(7) / 7, pose, lips, 50.1, np.float64(0.1), -1e9, 0.9, 45,
        "converged", terms={"colour": 1 / 7, "prior": 0.5}, belief=sure,
    )  # fmt: skip
    lost = FrameResult(index, False, np.full(7, np.nan), None, lips, *[np.nan] * 4, 0, "lost")
    memory = Memory(np.arange(7) / 7, pose, np.ones(7), (0.1, 1 / 3))
    return (result, memory) if index % 2 == 0 else (lost, Memory())


def same(a, b):
    """Whether two values are, field by field and bit by bit."""
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and a.tobytes() == b.tobytes()
    if hasattr(a, "__dataclass_fields__"):
        return all(same(getattr(a, n), getattr(b, n)) for n in a.__dataclass_fields__)
    return a == b or (a != a and b != b)


def test_frames_are_read_again_bit_by_bit_up_to_a_line_that_was_cut_off(tmp_path):
    path, frames = tmp_path / FRAMES, [found(k) for k in range(3)]
    with FrameJournal(path, "basis") as journal:
        for result, memory in frames:
            journal.add(result, memory)
    size, whole = path.stat().st_size, path.read_bytes()
    last = whole.rstrip(b"\n").rfind(b"\n") + 1
    for end in (size, size - 1, last + 9, last + 1):
        path.write_bytes(whole[:end])
        with FrameJournal(path, "basis") as journal:
            assert journal.resumed == (3 if end == size else 2)
            for k in range(journal.resumed):
                result, memory = journal.earlier()
                assert same(result, frames[k][0])
                assert same(memory, frames[k][1])
            assert journal.earlier() is None
            if end < size:
                journal.add(*frames[2])
        assert path.read_bytes() == whole


def test_earlier_frames_are_read_one_at_a_time(tmp_path):
    path = tmp_path / FRAMES
    with FrameJournal(path, "basis") as journal:
        for k in range(300):
            journal.add(*found(k))
    tracemalloc.start()
    with FrameJournal(path, "basis") as journal:
        assert sum(1 for _ in iter(journal.earlier, None)) == journal.resumed == 300
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < path.stat().st_size / 2


def test_frames_that_follow_from_something_else_are_forgotten(tmp_path):
    path = tmp_path / FRAMES
    with FrameJournal(path, "one") as journal:
        journal.add(*found(0))
    with FrameJournal(path, "other") as journal:
        assert journal.resumed == 0
        assert journal.earlier() is None
    with FrameJournal(path, "one") as journal:
        assert journal.resumed == 0


def test_a_fingerprint_sees_every_number_and_no_address():
    def value(last, pose=(0.0, 0.0, 500.0)):
        return (Pose(np.eye(3), np.array(pose)), {"a": [1, "x"], "b": last}, object())

    assert fingerprint(value(0.1)) == fingerprint(value(0.1))
    others = [value(0.1 + 1e-16), value("0.1"), value(0.1, (0.0, 0.0, 500.0000001))]
    assert len({fingerprint(one) for one in (value(0.1), *others)}) == 4
