"""The `live` command."""

from __future__ import annotations

import json
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from types import FrameType
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from abs_engine.cli.parts import options as take
from abs_engine.cli.parts.command import Chosen, Done, command
from abs_engine.cli.parts.drawing import opened
from abs_engine.cli.parts.given_files import check_files, track_options
from abs_engine.cli.parts.progress import Progress, interject, say
from abs_engine.cli.parts.settings import SETTINGS, settings_option, settings_text
from abs_engine.cli.parts.summary import warning_lines
from abs_engine.core.errors import OutputError
from abs_engine.core.registry import DRIVERS
from abs_engine.core.words import counted

if TYPE_CHECKING:
    from abs_engine.live.reader import Reader
    from abs_engine.live.release import Released
    from abs_engine.tracking.options import TrackOptions

_LEARN, _LOOK = 2.0, 0.2  # seconds of a stranger, and of a face that is known
_TOGETHER = 1.0  # seconds in which several signals are one request: `timeout` sends two
_NOTES = """\
Each line on stdout is a frame: names and units as in results.csv of a run, null where a number is
not known; delay_ms, the time since the frame was taken; dropped, the frames not tracked so far.
Ctrl-C ends the session, and the run is written.
"""


def _address(text: str) -> str:
    """HOST:PORT, as Unreal's Live Link Face listens at port 11111."""
    host, _, port = text.rpartition(":")
    if not host or not port.isdecimal() or not 0 < int(port) < 65536:
        raise click.BadParameter(f"'{text}' is not HOST:PORT, such as 127.0.0.1:11111")
    return text


@command(
    "Track and look at the result",
    take.argument("source", "[DEVICE|FILE|URL]", "a camera by its number or device, a file played "
        "at its own speed, or a URL", type=str, default="0"),
    take.output("RUN", "folder of the results, as 'track' writes it, once the session has ended",
        required=False),
    settings_option(),
    take.option("--delay", type=take.positive, default=120.0, metavar="MS",
        text="time from a frame to its result; frames not done by then are dropped (default: 120)"),
    take.option("--learn", type=take.positive, metavar="SECONDS",
        text="first seconds with a face, to learn the person from (default: 2; with --model 0.2)"),
    take.option("--repeat", type=take.count, default=1, metavar="N",
        text="how many times to play a file (default: 1)"),
    take.file("--model", metavar="me.face",
        text="a face that 'speaker' learned; tracking then starts within about a second"),
    take.option("--driver", metavar="NAME", type=take.Named(DRIVERS), default="newton-quick",
        text="what moves the parameters, as for 'track' (default: newton-quick)"),
    take.file("--camera", "camera.json of the camera's calibration"),
    take.option("--pupil-distance", type=take.number, metavar="MM",
        text="distance between the person's pupils; sets the scale (default: 63.4, adults' mean)"),
    take.option("--port", type=click.IntRange(0, 65535), metavar="N",
        text="port of the page on 127.0.0.1; 0: any free one (default: 8090, if it is free)"),
    take.option("--live-link", type=_address, metavar="HOST:PORT",
        text="where Live Link Face's packets go, by UDP: ARKit's 52 weights, the head's angles"),
    take.renderer(),
    take.option("--json", is_flag=True, default=True, hidden=True,
        text="stdout is JSON, a line for each frame, whether asked for or not"),
    examples="abs-engine live\n"
    "abs-engine live talk.mp4 --repeat 5 --renderer cpu > frames.ndjson\n"
    "abs-engine live rtsp://127.0.0.1:8554/cam -o tracked\n"
    "abs-engine live 1 -o again --settings tracked/settings.toml",
    notes=_NOTES,
)  # fmt: skip
def live(chosen: Chosen) -> Done:
    """Track a camera while it films."""
    from abs_engine.io.new_folder import NewFolder
    from abs_engine.io.video import VideoInfo
    from abs_engine.live.board import Board
    from abs_engine.live.feed import open_feed
    from abs_engine.live.keeper import Keeper
    from abs_engine.live.packets import LiveLink, reached
    from abs_engine.live.reader import Reader
    from abs_engine.live.server import served
    from abs_engine.live.session import ending, follow, learned
    from abs_engine.tracking.option_checks import check_options
    from abs_engine.tracking.run import remark_lines

    options = _checked(chosen)
    link = None if chosen.live_link is None else reached(chosen.live_link)
    feed = open_feed(take.at_home(chosen.source), _times(chosen))
    check_options(options, VideoInfo(feed.size, feed.rate, 0))
    output = chosen.output
    settings = "" if output is None else settings_text(live, vars(chosen), output)
    with ExitStack() as stack:
        made = None if output is None else stack.enter_context(NewFolder(output))
        renderer = stack.enter_context(opened(chosen.renderer))
        progress = stack.enter_context(Progress("live"))
        board = Board()
        progress.remark(f"page: {stack.enter_context(served(board, feed.name, chosen.port))}")
        reader = Reader(feed)
        usual = _LEARN if chosen.model is None else _LOOK
        seconds = usual if chosen.learn is None else chosen.learn

        def tell(stage: str) -> None:
            progress.announce(stage)
            board.stage(stage)

        tracker = learned(feed, reader, renderer, options, seconds, tell)
        if tracker.remarks:
            progress.remark(remark_lines(tracker))
        board.begin(tracker.setting)
        passed = counted(reader.count, "frame")
        progress.remark(f"tracking started; {passed} passed during preparation")
        takers = [_printer(reader), board.show]
        if link is not None:
            takers.append(stack.enter_context(LiveLink(link, tracker, interject)).send)
        keeper = None if made is None else Keeper(made.work, tracker)
        if keeper is not None:
            takers.append(keeper.add)

        def hand_on(released: Released) -> None:
            for taker in takers:
                taker(released)

        stack.enter_context(ends_orderly(reader))
        known = chosen.model is not None
        count = follow(tracker, reader, chosen.delay / 1e3, hand_on, say, known=known)
        (why, fault), dropped = ending(feed, reader), reader.count - count
        board.end(why)
        say(f"{why}; of {reader.count} frames {count} were tracked, {dropped} dropped")
        if made is not None and keeper is not None and count:
            facts = {"source": feed.name, "delay": chosen.delay, "dropped": dropped, "end": why}
            told = keeper.write(options, facts, Progress("writing"))
            (made.work / SETTINGS).write_text(settings, encoding="utf-8")
            made.finish()
            for line in warning_lines(told["summary"], tracker.remarks):
                say(line)
            say(f"wrote {output}")
    return Done((), status=2 if isinstance(reader.error, OutputError) else int(fault))


def _times(chosen: Chosen) -> int:
    """Number of times to play the source; what settings of another session say is of files."""
    from abs_engine.live.feed import is_file

    typed = click.get_current_context().get_parameter_source("repeat")
    of_file = is_file(take.at_home(chosen.source)) or typed is ParameterSource.COMMANDLINE
    return int(chosen.repeat) if of_file else 1


def _checked(chosen: Chosen) -> TrackOptions:
    """Options of tracking, whose files can be read and which go together."""
    from abs_engine.tracking.option_checks import check_choices

    options = track_options(chosen)
    if chosen.model is not None:
        options = replace(options, model=str(chosen.model))
    check_choices(options)
    check_files(options)
    return options


def _printer(reader: Reader) -> Callable[[Released], None]:
    """Prints results as lines of JSON; where nobody reads them any more, the session ends."""

    def line(released: Released) -> None:
        try:
            print(json.dumps(released.line()), flush=True)
        except BrokenPipeError:  # the session ends, and what came before is kept
            reader.stop()
        except OSError as error:
            said = f"stdout cannot be written ({error.strerror})"
            reader.stop(OutputError(said, "send it elsewhere"))

    return line


@contextmanager
def ends_orderly(reader: Reader) -> Iterator[None]:
    """Let the first Ctrl-C or SIGTERM end the session, not the program; a later one ends that.

    A later SIGHUP does not: the shell and the system each send one as a terminal closes.
    """
    first: float | None = None

    def stop(number: int, _frame: FrameType | None) -> None:
        nonlocal first
        now = time.monotonic()
        if first is None:
            first = now
            reader.stop()
        elif number != signal.SIGHUP and now - first >= _TOGETHER:
            raise KeyboardInterrupt

    asked = signal.SIGINT, signal.SIGTERM, signal.SIGHUP
    heeded = [number for number in asked if signal.getsignal(number) is not signal.SIG_IGN]
    before = [signal.signal(number, stop) for number in heeded]
    try:
        yield
    finally:
        for number, handler in zip(heeded, before, strict=True):
            signal.signal(number, handler)
