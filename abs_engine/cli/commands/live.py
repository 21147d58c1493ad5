"""The `live` command."""

from __future__ import annotations

import json
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from abs_engine.cli import options as take
from abs_engine.cli.command import Chosen, Done, command
from abs_engine.cli.drawing import opened

if TYPE_CHECKING:
    from abs_engine.live.reader import Reader
    from abs_engine.live.release import Released


@command(
    "Track and look at the result",
    take.argument("source", "[DEVICE|FILE|URL]", "a camera's number", type=str, default="0"),
    take.option("--delay", type=float, default=120.0, metavar="MS",
        text="time from a frame to its result; what is not done by then is dropped (default: 120)"),
    take.option("--learn", type=float, default=2.0, metavar="SECONDS",
        text="first seconds with a face, from which the person is learned (default: 2)"),
    take.option("--repeat", type=take.count, default=1, metavar="N",
        text="how often a file is played (default: 1)"),
    take.option("--model", metavar="me.face",
        text="the face that 'speaker' learned: nothing is then learned first"),
    take.renderer(),
    take.option("--json", is_flag=True, default=True, hidden=True,
        text="stdout is JSON, a line for each frame, whether asked for or not"),
    examples="abs-engine live\nabs-engine live talk.mp4 > frames.ndjson",
)  # fmt: skip
def live(chosen: Chosen) -> Done:
    """Track a camera while it films."""
    from abs_engine.live.feed import open_feed
    from abs_engine.live.lines import told
    from abs_engine.live.reader import Reader
    from abs_engine.live.session import Pace, follow, learned
    from abs_engine.tracking.options import TrackOptions

    feed = open_feed(chosen.source, chosen.repeat)
    options = TrackOptions(model=chosen.model)
    pace = Pace(chosen.learn, chosen.delay / 1e3)

    def hand_on(released: Released) -> None:
        print(json.dumps(told(released)), flush=True)

    with opened(chosen.renderer) as renderer:
        reader = Reader(feed)
        tracker = learned(feed, reader, renderer, options, pace, _say)
        _say(f"tracking; {reader.count} frames went by before")
        with _stopped_by_ctrl_c(reader):
            count = follow(tracker, reader, pace.delay, hand_on)
    dropped = reader.count - count
    _say(f"{feed.name} has ended: {reader.count} frames, {count} tracked, {dropped} dropped")
    return Done(())


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


@contextmanager
def _stopped_by_ctrl_c(reader: Reader) -> Iterator[None]:
    """Ctrl-C and SIGTERM end the session, and what was tracked is kept."""

    def stop(*_: Any) -> None:
        reader.stop()

    numbers = signal.SIGINT, signal.SIGTERM
    before = [signal.signal(number, stop) for number in numbers]
    try:
        yield
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)
