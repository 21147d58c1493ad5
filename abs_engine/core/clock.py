"""A clock of the parts of a frame."""

from __future__ import annotations

import json
import threading
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from abs_engine.core.threads import made_within

Item = TypeVar("Item")
TIMING = "timing.json"
"""What a result took: the only file of it that differs from one time to the next."""


class Clock:
    """Sums of processor seconds by what they were spent on.

    The clock is read by `read`: that of this process, all threads of it, or `time.thread_time`, for
    parts that run in threads beside each other.
    """

    def __init__(self, read: Callable[[], float] = time.process_time) -> None:
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self._read, self._lock = read, threading.Lock()

    @contextmanager
    def part(self, name: str) -> Iterator[None]:
        """Count the processor time inside as that of `name`."""
        start = self._read()
        try:
            yield
        finally:
            took = self._read() - start
            with self._lock:
                self.seconds[name] += took

    def over(self, name: str, items: Iterable[Item]) -> Iterator[Item]:
        """The same items, the time that making them takes counted as that of `name`."""
        return made_within(lambda: self.part(name), items)


def write_timing(folder: Path, timing: Mapping[str, Any]) -> None:
    """Write what a result took into its folder."""
    told = {"format": "abs_engine.timing", "version": 1, **timing}
    (folder / TIMING).write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")


def cost_lines(seconds: dict[str, float], frames: int) -> list[str]:
    """A table: milliseconds of one core that a frame took, by part, the dearest first."""
    total = sum(seconds.values())
    rows = sorted(seconds.items(), key=lambda item: -item[1])
    each = 1000 / max(frames, 1)
    lines = [f"{name:12} {value * each:7.1f} ms" for name, value in rows]
    return [*lines, f"{'all':12} {total * each:7.1f} ms of one core a frame, {frames} frames"]
