"""Says on stderr how far a command is."""

from __future__ import annotations

import sys
import time
from types import TracebackType

INTERVAL = 2.0  # seconds between lines where stderr is no terminal
_TERMINAL_INTERVAL = 0.1


class Progress:
    """Frames done, rate and time left; a context manager, called after every frame.

    A terminal sees one line that changes; a log sees a line every two seconds.

    Parameters
    ----------
    what : str
        What is being done.
    """

    def __init__(self, what: str) -> None:
        self._what = what
        self._terminal = sys.stderr.isatty()
        self._start = self._shown = time.perf_counter()
        self._dirty = False

    def restart(self, _seconds: float = 0.0) -> None:
        """Count the rate from now on."""
        self._start = self._shown = time.perf_counter()

    def announce(self, stage: str) -> None:
        """Name what goes before the first frame; a terminal shows it."""
        if self._terminal:
            self._line(f"{self._what}: {stage}")

    def __call__(self, done: int, total: int) -> None:
        """Show that `done` of `total` frames are done; 0 where the total is not known."""
        now = time.perf_counter()
        interval = _TERMINAL_INTERVAL if self._terminal else INTERVAL
        if now - self._shown < interval and not (self._terminal and done == total):
            return
        self._shown = now
        line = f"{self._what}: {progress_text(done, total, now - self._start)}"
        if self._terminal:
            self._line(line)
        else:
            sys.stderr.write(line + "\n")
            sys.stderr.flush()

    def _line(self, line: str) -> None:
        """Put a line in place of the last one."""
        sys.stderr.write(f"\r{line:78}")
        sys.stderr.flush()
        self._dirty = True

    def finish(self) -> None:
        """End the line of a terminal."""
        if self._dirty:
            sys.stderr.write("\n")
            sys.stderr.flush()
        self._dirty = False

    def __enter__(self) -> Progress:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.finish()


def progress_text(done: int, total: int, seconds: float) -> str:
    """Such as '30 of 75 frames, 9.8 frames/s, 5 s left'."""
    rate = done / max(seconds, 1e-6)
    if not total:
        return f"{done} frames, {rate:.1f} frames/s"
    left = (total - done) / max(rate, 1e-6)
    clock = f"{left:.0f} s" if left < 100 else f"{left / 60:.0f} min"
    return f"{done} of {total} frames, {rate:.1f} frames/s, {clock} left"
