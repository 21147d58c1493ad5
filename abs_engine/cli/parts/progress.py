"""Says on stderr how far a command is."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import click

INTERVAL = 2.0  # seconds between lines where stderr is no terminal
_TERMINAL_INTERVAL = 0.1
_TICK = 1.0  # seconds between the marks of a stage's clock on a terminal


def asked(name: str) -> bool:
    """Whether an option that every command has was typed: "quiet" or "json"."""
    context = click.get_current_context(silent=True)
    return context is not None and context.params.get(name) in (True, Path("-"))


def log(text: str) -> None:
    """Write to stderr, or nowhere where that is full or closed: the work goes on."""
    with suppress(OSError, ValueError):
        sys.stderr.write(text)
        sys.stderr.flush()


def say(line: str) -> None:
    """Print a part of the answer; on stderr where stdout is for JSON."""
    if asked("json"):
        log(f"{line}\n")
    else:
        print(line, flush=True)


def interject(line: str) -> None:
    """Print a line while a stage is under way; on a terminal it replaces that stage's line."""
    log(f"{_over(line)}\n" if sys.stderr.isatty() else f"{line}\n")


def _over(line: str) -> str:
    """A line in place of the last one on a terminal."""
    return f"\r{line:78}"


class Progress:
    """Stages, then frames done, rate and time left; a context manager, called after every frame.

    A terminal sees one line that changes; a log sees a line every two seconds at most; under
    `--quiet` neither sees anything.
    """

    def __init__(self, what: str, unit: str = "frames") -> None:
        self._what, self._unit = what, unit
        self._terminal, self._quiet = sys.stderr.isatty(), asked("quiet")
        self._start = self._shown = time.perf_counter()
        self._dirty = False
        self._clock: _Clock | None = None

    def announce(self, stage: str) -> None:
        """Name a stage that has no frames to count.

        A terminal shows it with a clock; a log gets a line once it has taken two seconds.
        """
        self._stop_clock()
        if self._terminal:
            self._show(stage)
            self._clock = _Clock(lambda s: self._show(f"{stage}, {s:.0f} s"), _TICK)
        else:
            self._clock = _Clock(lambda _: self._show(stage), INTERVAL, once=True)

    def restart(self, seconds: float = 0.0) -> None:
        """The stages are over after so many seconds: count the rate from now on."""
        self._stop_clock()
        if seconds >= INTERVAL:
            self._show(f"prepared in {seconds:.0f} s")
            self.finish()
        self._start = self._shown = time.perf_counter()

    def __call__(self, done: int, total: int) -> None:
        """Show that `done` of `total` frames are done; 0 where the total is not known."""
        self._stop_clock()
        now = time.perf_counter()
        interval = _TERMINAL_INTERVAL if self._terminal else INTERVAL
        if now - self._shown < interval and not (self._terminal and done == total):
            return
        self._shown = now
        self._show(progress_text(done, total, now - self._start, self._unit))

    def remark(self, line: str) -> None:
        """Print a line that is part of the answer, between stages and frames."""
        self.finish()
        say(line)

    def finish(self) -> None:
        """Stop the clock and end the line of a terminal."""
        self._stop_clock()
        if self._dirty:
            log("\n")
        self._dirty = False

    def _show(self, text: str) -> None:
        """A line of a log; on a terminal it replaces the last one."""
        if not self._quiet:
            log(_over(f"{self._what}: {text}") if self._terminal else f"{self._what}: {text}\n")
            self._dirty = self._terminal

    def _stop_clock(self) -> None:
        if self._clock is not None:
            self._clock.stop()
            self._clock = None

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        self.finish()


class _Clock:
    """Calls back with the seconds since it was made, from a thread, until it is stopped."""

    def __init__(self, tell: Callable[[float], None], interval: float, once: bool = False) -> None:
        self._tell, self._interval, self._once = tell, interval, once
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        start = time.perf_counter()
        while not self._ended.wait(self._interval):
            self._tell(time.perf_counter() - start)
            if self._once:
                return

    def stop(self) -> None:
        """Stop, and return when nothing more is told."""
        self._ended.set()
        self._thread.join()


def progress_text(done: int, total: int, seconds: float, unit: str = "frames") -> str:
    """Such as '30 of 75 frames, 9.8 frames/s, 5 s left'."""
    rate = done / max(seconds, 1e-6)
    if not total:
        return f"{done} {unit}, {rate:.1f} {unit}/s"
    left = (total - done) / max(rate, 1e-6)
    clock = f"{left:.0f} s" if left < 100 else f"{left / 60:.0f} min"
    return f"{done} of {total} {unit}, {rate:.1f} {unit}/s, {clock} left"
