"""Work beside other work: items made ahead of their use, calls made behind it, BLAS kept quiet.

And what each part of it costs.
"""

from __future__ import annotations

import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from functools import cache
from types import TracebackType
from typing import Any, TypeVar

from threadpoolctl import ThreadpoolController

Item = TypeVar("Item")
DEPTH = 4
"""Items, or calls, that wait at most: memory does not grow with a clip."""
_TURN = 1e-4  # seconds
_END = object()


def ahead(items: Iterable[Item], depth: int = DEPTH) -> Iterator[Item]:
    """The same items, made by a thread of their own up to `depth` ahead of their use.

    Meanwhile threads take turns in Python more often than usual: compiled loops that last a part
    of a millisecond would else wait for 5 ms after each.
    """
    source, usual = iter(items), sys.getswitchinterval()
    pool = ThreadPoolExecutor(1, "ahead")
    sys.setswitchinterval(_TURN)
    try:
        waiting = deque(pool.submit(next, source, _END) for _ in range(depth))
        while (item := waiting.popleft().result()) is not _END:
            waiting.append(pool.submit(next, source, _END))
            yield item  # type: ignore[misc]  # never _END
    finally:
        pool.shutdown(cancel_futures=True)
        sys.setswitchinterval(usual)


class Behind:
    """Calls made by a thread, in their order; a context manager that waits for them.

    A call that fails raises from a later one, or at the end.

    Parameters
    ----------
    depth : int
        Calls that wait at most.
    """

    def __init__(self, depth: int = DEPTH) -> None:
        self._pool, self._depth = ThreadPoolExecutor(1, "behind"), depth
        self._waiting: deque[Future[Any]] = deque()

    def call(self, what: Callable[..., Any], *given: Any) -> None:
        """Call `what` as soon as those before are done."""
        self._waiting.append(self._pool.submit(what, *given))
        while len(self._waiting) > self._depth:
            self._waiting.popleft().result()

    def __enter__(self) -> Behind:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._pool.shutdown(cancel_futures=kind is not None)
        if kind is None:
            for one in self._waiting:
                one.result()


class Spent:
    """Sums of processor seconds by what they were spent on, each in whatever thread it ran."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._lock = threading.Lock()

    @contextmanager
    def on(self, name: str) -> Iterator[None]:
        """Count the processor time of this thread as that of `name`."""
        start = time.thread_time()
        try:
            yield
        finally:
            took = time.thread_time() - start
            with self._lock:
                self.seconds[name] = self.seconds.get(name, 0.0) + took


class _Quiet:
    """How many ask for one thread of BLAS; the first limits it, the last lets it go."""

    def __init__(self) -> None:
        self._lock, self._count = threading.Lock(), 0
        self._limit: AbstractContextManager[Any] | None = None

    def enter(self) -> None:
        with self._lock:
            self._count += 1
            if self._limit is None:
                self._limit = _controller().limit(limits=1)

    def leave(self) -> None:
        with self._lock:
            self._count -= 1
            if self._count == 0 and self._limit is not None:
                self._limit.__exit__(None, None, None)
                self._limit = None


_QUIET = _Quiet()


@contextmanager
def one_thread() -> Iterator[None]:
    """Keep BLAS to one thread: on small matrices its threads wait for each other."""
    _QUIET.enter()
    try:
        yield
    finally:
        _QUIET.leave()


@cache
def _controller() -> ThreadpoolController:
    return ThreadpoolController()
