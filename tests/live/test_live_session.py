"""`abs-engine live` on a drawn head: its lines, packets and page, and the run after Ctrl-C."""

from __future__ import annotations

import errno
import http.client
import io
import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import tomllib
from types import SimpleNamespace

import numpy as np
import pytest
from browser import open_browser
from drawn import lit
from heads import seen_at
from hurried import PROGRAM
from runs import toy_result, write_kind

from abs_engine import export_run
from abs_engine.cli import main
from abs_engine.cli.commands import live as commands
from abs_engine.cli.commands.live import ends_orderly
from abs_engine.core.clock import Clock
from abs_engine.core.errors import VideoError
from abs_engine.io.video import probe
from abs_engine.live import session as session_module
from abs_engine.live.board import Board
from abs_engine.live.feed import file_feed
from abs_engine.live.reader import Reader
from abs_engine.live.release import Released
from abs_engine.live.server import served
from abs_engine.live.session import ending, follow
from abs_engine.tracking.runs.record import load_run

FRAMES, RATE, LEARN = 5, 5, 0.8
PICTURE = """
const c = document.getElementById('film'), g = c.getContext('2d');
const d = g.getImageData(0, 0, c.width, c.height).data;
return [c.width, c.height, Array.from(d.filter((_, k) => k % 4 === 1)).reduce((a, b) => a + b)];"""
HEAD = """
const c = document.getElementById('head'), g = document.createElement('canvas').getContext('2d');
g.drawImage(c, 0, 0, 300, 150);
return new Set(g.getImageData(0, 0, 300, 150).data).size;"""
FITTED = """
const fits = (c) => c.width === Math.round(c.clientWidth * devicePixelRatio);
(function look() {
  const all = ['head', 'curves'].map((id) => document.getElementById(id));
  innerWidth <= 600 && all.every(fits) ? done(1) : setTimeout(look, 100);
})();"""
SHOWN = "(function look() { live.drawn > 2 ? done(1) : setTimeout(look, 100); })();"


def refused(capsys, *words):
    """The one line with which a command is refused."""
    assert main(["live", *map(str, words), "--renderer", "cpu"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert lines[-1].startswith("abs-engine: error: ")
    return lines[-1]


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    """A drawn head that opens its mouth, slowly: fewer frames are tracked while the page opens."""
    pictures = [
        lit("amara", seen_at([0, 0.05 * k - 0.1, 0], [0, 0, 700]), jawOpen=0.07 * k)
        for k in range(FRAMES)
    ]
    return write_kind(tmp_path_factory.mktemp("film") / "head.mp4", "libx264", pictures, rate=RATE)


class Listener(threading.Thread):
    """Takes UDP packets as they come: what waits in a socket is limited, and the rest is lost."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.packets, self._come = [], threading.Condition()

    def run(self) -> None:
        while packet := self.socket.recv(1000):
            with self._come:
                self.packets.append(packet)
                self._come.notify_all()

    def first(self, count: int) -> list[bytes]:
        """So many packets, once they have come."""
        with self._come:
            assert self._come.wait_for(lambda: len(self.packets) >= count, 10), len(self.packets)
            return self.packets[:count]


@pytest.fixture
def listener():
    """A UDP socket whose packets are kept."""
    found = Listener()
    found.start()
    yield found
    found.socket.sendto(b"", found.socket.getsockname())  # ends the thread
    found.join(10)
    found.socket.close()


@pytest.fixture
def session(film, tmp_path, listener):
    """A session that goes on until it is stopped; what it says on stderr, and its lines."""
    to = f"127.0.0.1:{listener.socket.getsockname()[1]}"
    words = ["live", film, "--repeat", 100000, "--renderer", "cpu", "--port", 0, "--delay", 4000]
    words += ["--learn", LEARN, "--live-link", to, "-o", tmp_path / "run"]
    command = [sys.executable, "-c", PROGRAM, *map(str, words)]
    pipe = subprocess.PIPE
    # A job in the background ignores Ctrl-C, and so would what it starts
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True) as process:
        signal.signal(signal.SIGINT, before)
        yield process
        process.kill()


def asked(address, path, host):
    """Status and content type of what the page's server answers."""
    connection = http.client.HTTPConnection(address, timeout=10)
    connection.request("GET", path, headers={"Host": host})
    answer = connection.getresponse()
    answer.read()
    return answer.status, answer.headers["Content-Type"]


@pytest.mark.slow
def test_a_session_is_shown_sent_and_kept(session, tmp_path, listener):
    said = []
    address = None
    while address is None:
        said.append(session.stderr.readline())
        found = re.search(r"page: http://(127\.0\.0\.1:\d+)/", said[-1])
        address = found and found[1]
    rest = threading.Thread(target=lambda: said.extend(session.stderr), daemon=True)
    rest.start()
    assert asked(address, "/", address) == (200, "text/html; charset=utf-8")
    assert asked(address, "/", "evil.example:80")[0] == 403
    assert asked(address, "/other", address)[0] == 404

    with open_browser(tmp_path / "profile") as page:
        page.driver.get(f"http://{address}/")
        assert page.wait(SHOWN) == 1
        assert page.run("return document.getElementById('state').textContent").count(" ms") == 1
        width, height, light = page.run(PICTURE)
        assert (width, height) == (640, 480)
        assert light / (width * height) > 40
        assert page.run(HEAD) > 20
        assert page.complaints() == []
        assert all(url.startswith(f"http://{address}/") for url in page.strange_requests())
        lines = [json.loads(session.stdout.readline()) for _ in range(4)]
        session.send_signal(signal.SIGINT)
        lines += [json.loads(line) for line in session.stdout]
        ended = page.run("return document.getElementById('state').textContent")
        page.driver.set_window_size(600, 700)  # no frame will be drawn again
        assert page.wait(FITTED) == 1
    assert ended in ("stopped", "the session has ended") or "dropped" in ended
    assert session.wait(60) == 0
    rest.join()

    assert [line["index"] - line["dropped"] for line in lines] == list(range(len(lines)))
    assert all(line["found"] and 4000 <= line["delay_ms"] < 4100 for line in lines)
    assert any("stopped; of " in line and f" {len(lines)} were tracked" in line for line in said)
    run = load_run(tmp_path / "run")
    told = json.loads((tmp_path / "run" / "run.json").read_text())["settings"]
    time = run["time"] + told["live"]["began"]
    np.testing.assert_allclose(time, [line["time"] for line in lines], atol=1e-4)
    np.testing.assert_allclose(run["aperture"], [line["aperture"] for line in lines], atol=1e-4)
    assert run["index"].tolist() == list(range(len(lines)))
    assert (told["video_path"], told["live"]["end"]) == ("recording.mkv", "stopped")
    assert not list((tmp_path / "run").glob("*.journal"))
    settings = tomllib.loads((tmp_path / "run" / "settings.toml").read_text())
    assert (settings["delay"], settings["renderer"], settings["learn"]) == (4000.0, "cpu", LEARN)
    assert settings["live-link"].startswith("127.0.0.1:")
    recording = probe(tmp_path / "run" / "recording.mkv")
    assert recording.frames == len(lines)
    np.testing.assert_allclose(recording.times, run["time"], atol=1.1e-3)
    assert export_run(tmp_path / "run", "arkit", tmp_path / "run.csv")
    assert {len(one) for one in listener.first(len(lines))} == {316}


@pytest.mark.parametrize(
    ("host", "status"),
    [("127.0.0.1", 200), ("localhost", 200), ("localhost:80", 200), ("evil.example", 403)],
)
def test_a_browser_leaves_out_the_port_where_it_is_80(host, status):
    with served(Board(), "head", 0) as address:
        assert asked(address.split("/")[2], "/", host)[0] == status


@pytest.mark.parametrize("known", [False, True])
def test_a_feed_that_ends_before_a_frame_is_tracked_is_refused(film, known):
    nothing = SimpleNamespace(finish=lambda: None)
    motion = SimpleNamespace(follower=lambda: nothing)
    setting = SimpleNamespace(motion=motion, clock=Clock(), renderer=None)
    reader = Reader(file_feed(film))
    reader.collect(60.0)
    list(reader.shots())
    with pytest.raises(VideoError, match="5 frames had gone by before one was tracked") as caught:
        follow(SimpleNamespace(setting=setting), reader, 1.0, print, print, known=known)
    assert ("give a learned --model" in caught.value.remedy) != known


@pytest.fixture
def interruptible():
    """Ctrl-C is heeded, also where the tests run in the background of a shell, which ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("then", [signal.SIGTERM, signal.SIGINT])
def test_the_first_signal_ends_the_session_and_a_later_one_the_program(film, monkeypatch, then):
    monkeypatch.setattr(commands, "_TOGETHER", 0.0)
    before, reader = signal.getsignal(signal.SIGTERM), Reader(file_feed(film))
    with ends_orderly(reader):
        signal.raise_signal(signal.SIGTERM)
        assert list(reader.shots()) == []
        assert ending(file_feed(film), reader) == ("stopped", False)
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(then)
    assert signal.getsignal(signal.SIGTERM) is before


@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize(
    ("together", "then"), [(0.0, signal.SIGHUP), (1e9, signal.SIGTERM), (1e9, signal.SIGINT)]
)
def test_signals_of_one_request_count_once(film, monkeypatch, together, then):
    """A shell and the system each send SIGHUP as a terminal closes; `timeout` sends two."""
    monkeypatch.setattr(commands, "_TOGETHER", together)
    with ends_orderly(Reader(file_feed(film))):
        signal.raise_signal(signal.SIGHUP)
        signal.raise_signal(then)


@pytest.mark.usefixtures("interruptible")
def test_a_signal_after_the_lines_were_closed_is_the_first(film):
    reader = Reader(file_feed(film))
    with ends_orderly(reader):
        reader.stop()
        signal.raise_signal(signal.SIGINT)


class Unwritable(io.StringIO):
    """A stream that takes nothing."""

    def __init__(self, number):
        super().__init__()
        self.number = number

    def write(self, _text):
        raise OSError(self.number, os.strerror(self.number))


@pytest.fixture
def short(film, tmp_path, monkeypatch):
    """A session of two results, without a tracker; the exit status, and the facts of its run."""
    facts = {}

    class Kept:
        def __init__(self, folder, _tracker):
            self.folder, self.add = folder, lambda _: None

        def write(self, _options, told, _progress):
            facts.update(told)
            return {"summary": {"warnings": ["the head does not match", "a cup hides the lips"]}}

    def two(_tracker, reader, _delay, hand_on, _tell, *, known):
        assert not known
        shot = next(reader.shots())
        for index in range(2):
            hand_on(Released(shot, toy_result(index), 0.1, 0))
        reader.stop()
        return 2

    def run():
        setting = SimpleNamespace(warnings=("the head does not match",))
        made = SimpleNamespace(setting=setting, remarks="2 faces\nthe head does not match")
        monkeypatch.setattr(session_module, "learned", lambda *_: made)
        monkeypatch.setattr(session_module, "follow", two)
        monkeypatch.setattr("abs_engine.live.keeper.Keeper", Kept)
        monkeypatch.setattr("abs_engine.live.board.Board.begin", lambda *_: None)
        words = ["live", film, "--renderer", "cpu", "--port", 0, "-o", tmp_path / "run"]
        return main(list(map(str, words))), facts

    return run


def test_a_run_is_kept_where_stderr_is_gone(short, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("sys.stderr", Unwritable(errno.EIO))
    status, facts = short()
    assert (status, facts["end"]) == (0, "stopped")
    assert len(capsys.readouterr().out.splitlines()) == 2
    assert (tmp_path / "run" / "settings.toml").is_file()


def test_what_is_to_be_known_of_the_face_is_said_before_it_is_tracked(short, capsys):
    short()
    said = capsys.readouterr().err.splitlines()
    at = said.index("2 faces")
    assert said[at + 1] == "warning: the head does not match"
    assert said[at + 2].startswith("tracking started; ")


def test_what_a_run_warns_of_is_said_at_its_end_unless_it_was_before(short, capsys):
    short()
    said = capsys.readouterr().err.splitlines()
    warned = [line for line in said if line.startswith("warning: ")]
    assert warned == ["warning: the head does not match", "warning: a cup hides the lips"]
    assert said[-2] == warned[-1]


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EIO])
def test_a_run_is_kept_where_stdout_takes_nothing(short, tmp_path, monkeypatch, capsys, number):
    monkeypatch.setattr("sys.stdout", Unwritable(number))
    status, facts = short()
    said = f"stdout cannot be written ({os.strerror(number)}); send it elsewhere"
    assert (status, facts["end"]) == (2, said)
    *_, ended, _, wrote = capsys.readouterr().err.splitlines()
    assert ended.startswith(f"{said}; of ")
    assert wrote == f"wrote {tmp_path / 'run'}"
    assert (tmp_path / "run" / "settings.toml").is_file()


def test_wrong_words_are_refused(film, tmp_path, capsys):
    assert "'nowhere' is not HOST:PORT" in refused(capsys, film, "--live-link", "nowhere")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        assert f"port {port} cannot be used" in refused(capsys, film, "--port", port)
    assert "does not exist" in refused(capsys, tmp_path / "none.mp4")
    for value in ("-3", "0", "nan", "soon"):
        assert "is not a number" in refused(capsys, film, "--delay", value)
    assert "is not a number above 0" in refused(capsys, film, "--learn", "-1")


@pytest.mark.parametrize(
    ("option", "value"),
    [("--pupil-distance", "1000"), ("--live-link", "nowhere.invalid:1"), ("--model", __file__)],
)
def test_it_is_refused_before_a_renderer_opens(film, capsys, monkeypatch, option, value):
    opened: list[object] = []
    monkeypatch.setattr(commands, "opened", opened.append)
    refused(capsys, film, option, value)
    assert not opened


def test_a_folder_that_exists_is_refused(film, tmp_path, capsys):
    tmp_path.joinpath("run").mkdir()
    assert "exists" in refused(capsys, film, "-o", tmp_path / "run")
