"""Live frames: only the newest waits, late results are dropped, and how a source ends is known."""

from __future__ import annotations

import http.server
import re
import signal
import socket
import threading
import time
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np
import pytest

from abs_engine.core.errors import InputFileError, ParameterError, VideoError
from abs_engine.io.video import VideoWriter
from abs_engine.live.feed import camera_feed, file_feed, open_feed
from abs_engine.live.reader import Reader
from abs_engine.live.release import RECENT, Release
from abs_engine.live.session import ending
from abs_engine.tracking.frame.frame_state import Shot

IMAGE = np.zeros((32, 48, 3), np.uint8)
PERIOD = 0.02


@dataclass(frozen=True)
class Result:
    """What is handed on of a frame's result."""

    status: str = "found"
    cut: bool = False


class Steps:
    """A feed that goes on by one frame each time it is let."""

    name, size, rate, lost = "steps", (48, 32), 50.0, True

    def __init__(self, count, broken=None):
        self.count, self.broken = count, broken
        self.let = threading.Semaphore(0)

    def frames(self):
        for k in range(self.count):
            self.let.acquire()
            yield np.full_like(IMAGE, k), 100.0 + PERIOD * k
        self.let.acquire()
        if self.broken:
            raise self.broken

    def go(self, reader, frames):
        """Let frames come, and wait for them."""
        wanted = reader.count + frames
        for _ in range(frames):
            self.let.release()
        waited(lambda: reader.count == wanted)


def waited(for_it, seconds=5.0):
    end = time.monotonic() + seconds
    while not for_it():
        assert time.monotonic() < end
        time.sleep(0.001)


def test_only_the_newest_frame_waits():
    feed = Steps(9)
    reader = Reader(feed)
    shots = reader.shots()
    feed.go(reader, 3)
    first = next(shots)
    assert (first.index, first.image.max()) == (2, 2)
    assert first.time == pytest.approx(2 * PERIOD)
    feed.go(reader, 4)
    assert next(shots).index == 6
    feed.go(reader, 2)
    feed.let.release()
    assert [shot.index for shot in shots] == [8]
    assert ending(feed, reader) == ("steps gives no more frames: is it unplugged?", True)


def test_every_frame_is_learned_from_and_what_a_feed_ended_by_is_known():
    feed = Steps(6, VideoError("it breaks off", "look at it"))
    reader = Reader(feed)
    for _ in range(7):
        feed.let.release()
    collected = reader.collect(10.0)
    assert collected[-1].index == 5
    assert len(reader.collect(1.0)) == 0
    assert str(reader.error) == "it breaks off; look at it"
    assert ending(feed, reader) == ("it breaks off; look at it", True)


def test_an_error_of_a_library_is_a_fault(monkeypatch):
    raised = threading.Event()
    monkeypatch.setattr(threading, "excepthook", lambda _: raised.set())  # Python's own prints it
    feed = Steps(0, RuntimeError("no memory"))
    reader = Reader(feed)
    feed.let.release()
    assert list(reader.shots()) == []
    assert raised.wait(10)
    said = "steps breaks off (RuntimeError('no memory')); start again"
    assert ending(feed, reader) == (said, True)


def test_frames_are_collected_for_as_long_as_asked():
    feed = Steps(50)
    reader = Reader(feed)
    made = []
    thread = threading.Thread(target=lambda: made.append(reader.collect(5 * PERIOD)))
    thread.start()
    while thread.is_alive():
        feed.let.release()
        thread.join(0.01)
    times = [shot.time for shot in made[0]]
    assert 5 * PERIOD <= times[-1] - times[0] < 8 * PERIOD
    reader.stop()
    assert list(reader.shots()) == []
    assert ending(feed, reader) == ("stopped", False)


def test_results_are_handed_on_at_a_constant_delay_and_late_ones_dropped():
    handed, start = [], time.monotonic()
    with Release(start, 0.3, handed.append) as release:
        release.add(Shot(IMAGE, 0, -0.4), Result("late"))
        release.add(Shot(IMAGE, 1, 0.0), Result("early"))
        release.add(Shot(IMAGE, 4, 0.1), Result("later"))
    assert [(one.result.status, one.shot.index, one.dropped) for one in handed] == [
        ("early", 1, 1),
        ("later", 4, 3),
    ]
    for one in handed:
        assert 0.3 <= one.delay < 1.0  # on a slow machine, too
    assert time.monotonic() - start > 0.4
    assert release.count == 2


def test_what_nobody_takes_in_time_is_dropped():
    handed = []

    def slow(released):
        handed.append(released.shot.index)
        time.sleep(0.6)

    with Release(time.monotonic(), 0.3, slow) as release:
        for k in range(3):
            release.add(Shot(IMAGE, k, 0.01 * k), Result())
    assert handed == [0]


def test_a_shot_whose_first_frame_is_late_begins_with_the_next_one():
    handed = []
    with Release(time.monotonic(), 0.3, handed.append) as release:
        release.add(Shot(IMAGE, 0, -0.4), Result("late", cut=True))
        release.add(Shot(IMAGE, 1, 0.0), Result())
        release.add(Shot(IMAGE, 2, -0.4), Result("late", cut=True))
        release.add(Shot(IMAGE, 3, 0.05), Result())
        release.add(Shot(IMAGE, 4, 0.05), Result())
    assert [one.result.cut for one in handed] == [False, True, False]  # none before the first


def test_results_that_mostly_come_too_late_are_noticed():
    with Release(time.monotonic(), 0.5, lambda _: None) as release:
        for k in range(RECENT - 1):
            release.add(Shot(IMAGE, k, -1.0), Result("late"))
            assert not release.mostly_late
        release.add(Shot(IMAGE, RECENT, 0.0), Result())
        assert release.mostly_late
        for k in range(RECENT // 2 + 1):
            assert release.mostly_late == (k < RECENT // 2)
            release.add(Shot(IMAGE, k, 0.0), Result())


def test_an_error_of_who_takes_results_is_raised():
    def fails(_):
        raise OSError("disk full")

    with (
        pytest.raises(OSError, match="disk full"),
        Release(time.monotonic(), 0.5, fails) as release,
    ):
        release.add(Shot(IMAGE, 0, 0.0), Result())


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    path = tmp_path_factory.mktemp("film") / "film.mp4"
    with VideoWriter(path, (48, 32), 50.0) as video:
        for k in range(10):
            video.write(np.full_like(IMAGE, 20 * k))
    return path


def test_a_file_is_played_at_its_own_speed_as_often_as_asked(film):
    feed = file_feed(film, repeat=2)
    times = [(taken, time.monotonic()) for _, taken in feed.frames()]
    due, came = np.array(times).T
    np.testing.assert_allclose(np.diff(due), PERIOD, atol=1e-6)
    assert (came >= due).all()


def test_a_url_that_ends_is_said(film):
    handler = partial(http.server.SimpleHTTPRequestHandler, directory=str(film.parent))
    handler.func.log_message = lambda *_: None
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        feed = open_feed(f"http://127.0.0.1:{server.server_port}/film.mp4")
        server_ends = server.shutdown
        assert (feed.size, feed.rate, feed.lost) == ((48, 32), 50.0, False)
        reader = Reader(feed)
        shots = reader.collect(60.0)
        server_ends()
    assert [shot.index for shot in shots] == list(range(10))
    assert np.abs(shots[9].image.mean() - 180) < 4
    assert shots[9].time == pytest.approx(9 * PERIOD, abs=1e-3)
    assert ending(feed, reader) == (f"{feed.name} has ended", False)


@contextmanager
def sent(*parts, length=None):
    """A URL that gives so many bytes, and then ends; its server says no length unless asked to."""
    head = b"HTTP/1.0 200 OK\r\n" + (b"Content-Length: %d\r\n" % length if length else b"")
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve():
            connection, _ = server.accept()
            with connection:
                connection.recv(4096)
                connection.sendall(b"".join((head, *parts)))

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        yield f"http://127.0.0.1:{server.getsockname()[1]}/film"
        thread.join()


def jpegs(*sizes):
    """Pictures as a camera on the network sends them, the end of the head first."""
    yield b"Content-Type: multipart/x-mixed-replace; boundary=b\r\n\r\n"
    for size in sizes:
        data = cv2.imencode(".jpg", np.zeros((*size[::-1], 3), np.uint8))[1].tobytes()
        yield b"--b\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % len(data)
        yield data + b"\r\n"


def test_a_live_url_that_ends_is_a_fault_and_nothing_else_is_said(capfd):
    with sent(*jpegs((48, 32), (48, 32), (48, 32))) as url:
        feed = open_feed(url)
        assert (feed.size, feed.lost) == ((48, 32), True)
        reader = Reader(feed)
        assert len(reader.collect(60.0)) == 3
    assert ending(feed, reader)[1]
    assert capfd.readouterr().err == ""


def test_a_url_that_changes_its_size_is_not_tracked_on():
    with sent(*jpegs((48, 32), (48, 32), (64, 32))) as url:
        feed = open_feed(url)
        reader = Reader(feed)
        assert len(reader.collect(60.0)) == 2
    assert ending(feed, reader) == (f"{url} has changed its size; start again", True)


@pytest.mark.parametrize("states", [True, False])
@pytest.mark.parametrize("share", [0.5, 1])
def test_a_film_behind_a_url_that_breaks_off_is_told_from_one_that_ends(tmp_path, share, states):
    path, rng = tmp_path / "film.mkv", np.random.default_rng(0)
    with VideoWriter(path, (48, 32), 50.0) as video:
        for _ in range(40):
            video.write(rng.integers(0, 255, IMAGE.shape, np.uint8))
    film = path.read_bytes()
    part = film[: int(share * len(film))]
    with sent(b"\r\n", part, length=states and len(film)) as url:
        feed = open_feed(url)
        reader = Reader(feed)
        count = len(reader.collect(60.0))
    said, fault = ending(feed, reader)
    assert fault == (share < 1)
    if fault:
        assert 0 < count < 40
        assert re.search(rf"breaks off after {count} frames \(at 0\.\d of 0\.8 s\)", said)
    else:
        assert (count, said) == (40, f"{url} has ended")


def test_an_interrupt_does_not_wait_for_a_url():
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    with socket.create_server(("127.0.0.1", 0)) as server:

        def interrupt():
            connection, _ = server.accept()
            with connection:
                connection.recv(4096)
                signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
                over.wait(60)

        over, start = threading.Event(), time.monotonic()
        thread = threading.Thread(target=interrupt, daemon=True)
        thread.start()
        try:
            with pytest.raises(KeyboardInterrupt):
                open_feed(f"http://127.0.0.1:{server.getsockname()[1]}/film")
        finally:
            signal.signal(signal.SIGINT, before)
            over.set()
            thread.join()
    assert time.monotonic() - start < 25  # FFmpeg waits for 30 s


def test_a_camera_that_is_unplugged_is_said(monkeypatch):
    class Unplugged:
        def __init__(self, source):
            assert source == 3
            self.left = 4

        def isOpened(self):
            return True

        def read(self):
            self.left -= 1
            return self.left >= 0, (np.full_like(IMAGE, [0, 0, 200]) if self.left >= 0 else None)

        def get(self, what):
            return {cv2.CAP_PROP_FPS: 0.0, cv2.CAP_PROP_FRAME_COUNT: -1.0}[what]

        def set(self, *_):
            return True

        def release(self):
            self.left = 0

    monkeypatch.setattr(cv2, "VideoCapture", Unplugged)
    feed = camera_feed("3")
    reader = Reader(feed)
    shots = reader.collect(60.0)
    assert len(shots) == reader.count == 4
    assert (shots[0].image == [200, 0, 0]).all()  # OpenCV's colours are the other way round
    assert ending(feed, reader) == ("camera 3 gives no more frames: is it unplugged?", True)


@pytest.mark.parametrize("source", ["63", "/dev/video63", "http://127.0.0.1:9/none.mp4"])
def test_what_is_no_file_is_not_repeated(source):
    with pytest.raises(ParameterError, match="--repeat is for files"):
        open_feed(source, 3)


@pytest.mark.parametrize(
    ("source", "error", "said"),
    [
        ("63", VideoError, "camera 63 cannot be opened"),
        ("99999999999", VideoError, "camera 99999999999 cannot be opened"),
        ("http://\udcff", VideoError, "cannot be opened"),
        ("http://127.0.0.1:9/none.mp4", VideoError, "cannot be opened"),
        ("no-such.mp4", InputFileError, "does not exist"),
    ],
)
def test_a_source_that_is_not_there_is_refused(source, error, said):
    with pytest.raises(error, match=said):
        open_feed(source)
