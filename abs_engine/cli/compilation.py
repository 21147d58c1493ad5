"""Notice that inner loops are compiled, which the first run after an installation waits for."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from numba.core.event import Event, Listener, register, unregister

LEAST = 1.0  # seconds that are worth a line: an update may leave one small loop to compile
NOTICE = "compiling inner loops, once after an installation: about half a minute"


class _Compiling(Listener):
    """Calls back once, when compiling has taken `LEAST` seconds."""

    def __init__(self, tell: Callable[[str], None]) -> None:
        self._tell = tell
        self._lock = threading.Lock()
        self._begun: dict[int, list[float]] = {}
        self._seconds, self._told = 0.0, False

    def on_start(self, event: Event) -> None:
        """A function, or one that it calls, begins to be compiled."""
        with self._lock:
            self._begun.setdefault(threading.get_ident(), []).append(time.perf_counter())

    def on_end(self, event: Event) -> None:
        """It is compiled; what it calls is counted with it."""
        with self._lock:
            stack = self._begun[threading.get_ident()]
            began = stack.pop()
            if not stack:
                self._seconds += time.perf_counter() - began
            now = self._seconds >= LEAST and not self._told
            self._told = self._told or now
        if now:
            self._tell(NOTICE)


@contextmanager
def compilation_noticed(tell: Callable[[str], None]) -> Iterator[None]:
    """Say so, once, if the commands within have to compile for long."""
    listener = _Compiling(tell)
    register("numba:compile", listener)
    try:
        yield
    finally:
        unregister("numba:compile", listener)
