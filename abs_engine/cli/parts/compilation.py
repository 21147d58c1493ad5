"""Notice that inner loops are compiled, which the first run after an installation waits for."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from numba.core.event import Event, Listener, register, unregister

LEAST = 1.0  # seconds that are worth a line: an update may leave one small loop to compile
NOTICE = "compiling inner loops, once after an installation: up to half a minute"


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
        """It is compiled; what it calls is counted with it, as long as that lasts."""
        with self._lock:
            stack = self._begun.get(threading.get_ident())
            if not stack:
                return  # it began before this listened
            total = self._seconds + time.perf_counter() - stack[0]  # since the outermost began
            stack.pop()
            if not stack:
                self._seconds = total
            now = total >= LEAST and not self._told
            self._told = self._told or now
        if now:
            self._tell(NOTICE)


@contextmanager
def compilation_noticed(tell: Callable[[str], None]) -> Iterator[None]:
    """Call `tell` once, if what runs within compiles for `LEAST` seconds."""
    listener = _Compiling(tell)
    register("numba:compile", listener)
    try:
        yield
    finally:
        unregister("numba:compile", listener)
