"""Work beside other work: items made ahead of their use, calls made behind it, quiet libraries."""

from __future__ import annotations

import sys
import threading
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import AbstractContextManager, contextmanager
from functools import lru_cache, update_wrapper
from typing import Any, TypeVar

import cv2
from threadpoolctl import OpenBLASController, ThreadpoolController

Item = TypeVar("Item")
DEPTH = 4
"""Items, or calls, that wait at most: memory does not grow with a clip."""
_TURN = 1e-4  # seconds
_MOST = 4  # threads that are kept
_END = object()
_HERE = threading.local()
_BESIDE = ThreadPoolExecutor(_MOST, "beside")
_alone = False
"""Whether this process is to keep to one core; see `keep_to_one_core`."""


def keep_to_one_core() -> None:
    """Work in one thread from now on, also in OpenCV, as other processes use the other cores.

    What is found is the same.
    """
    global _alone
    _alone = True
    cv2.setNumThreads(1)


def ahead(items: Iterable[Item], depth: int = DEPTH) -> Iterator[Item]:
    """The same items, made by a thread of their own up to `depth` ahead of their use.

    Meanwhile threads take turns in Python more often than usual: compiled loops that last a part
    of a millisecond would else wait for 5 ms after each.
    """
    source = iter(items)
    if _alone:
        yield from source
        return
    pool = ThreadPoolExecutor(1, "ahead")
    with _OFTEN.used():
        try:
            waiting = deque(pool.submit(next, source, _END) for _ in range(depth))
            while (item := waiting.popleft().result()) is not _END:
                waiting.append(pool.submit(next, source, _END))
                yield item  # type: ignore[misc]  # never _END
        finally:
            pool.shutdown(cancel_futures=True)


def begin(what: Callable[..., Any], *given: Any) -> None:
    """Call `what` in another thread and return at once; not where the process keeps to one core.

    Its errors are dropped. Nothing waits for it until the process ends.
    """

    def call() -> None:
        with _OFTEN.used():
            what(*given)

    if not _alone:
        _BESIDE.submit(call)


def kept(make: Callable[..., Item]) -> Callable[..., Item]:
    """The function with its last result kept; threads that ask at once wait for one of them."""
    last, lock = lru_cache(maxsize=1)(make), threading.Lock()

    def known(*given: Any) -> Item:
        with lock:
            return last(*given)

    return update_wrapper(known, last)


@contextmanager
def meanwhile(what: Callable[..., Item], *given: Any) -> Iterator[Future[Item]]:
    """Call `what` in a thread beside what is done inside; the context ends when both are done."""
    if _alone:
        made: Future[Item] = Future()
        made.set_result(what(*given))
        yield made
        return
    with _OFTEN.used(), ThreadPoolExecutor(1, "meanwhile") as pool:
        yield pool.submit(what, *given)


def in_threads(what: Callable[[Any], Item], items: Iterable[Any], count: int = 2) -> list[Item]:
    """Results of all items, in their order, some of them worked on at once.

    It is of use where most of the work is done by compiled loops, BLAS or OpenCV, which let other
    threads run; with a `count` of 1 all is done in this one, and so within an item. Threads are
    kept for the next call, with what they have made for themselves.
    """
    given = list(items)
    if count == 1 or _alone or len(given) < 2 or getattr(_HERE, "within", False):
        return [what(one) for one in given]
    found: list[Any] = [None] * len(given)
    failed: dict[int, Exception] = {}
    left = iter(range(len(given)))

    def take() -> None:
        _HERE.within = True
        try:
            for k in left:
                found[k] = what(given[k])
        except Exception as error:  # noqa: BLE001 - raised again below
            failed[k] = error
        finally:
            _HERE.within = False
            deque(left, 0)  # once one has failed, no more are begun

    with _OFTEN.used():
        beside = [_BESIDE.submit(take) for _ in range(min(count, len(given)) - 1)]
        try:
            take()
        finally:  # interrupted, too: what they work with may be closed next
            wait([one for one in beside if not one.cancel()])
    if failed:
        raise failed[min(failed)]
    return found


def workers(renderer: object) -> int:
    """Threads that may draw at once with a renderer, one for each of two cores at most."""
    return 2 if getattr(renderer, "concurrent", False) else 1


class Behind:
    """Calls made by a thread, in their order; a context manager that waits for them.

    A call that fails raises from a later one, or at the end. At most `depth` calls wait.
    """

    def __init__(self, depth: int = DEPTH) -> None:
        self._pool, self._depth = ThreadPoolExecutor(1, "behind"), depth
        self._waiting: deque[Future[Any]] = deque()

    def call(self, what: Callable[..., Any], *given: Any) -> None:
        """Call `what` as soon as those before are done."""
        if _alone:
            what(*given)
            return
        self._waiting.append(self._pool.submit(what, *given))
        while len(self._waiting) > self._depth:
            self._waiting.popleft().result()

    def __enter__(self) -> Behind:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self._pool.shutdown(cancel_futures=kind is not None)
        if kind is None:
            for one in self._waiting:
                one.result()


class _Counted:
    """Context that the first user begins and the last one ends, in whatever order they leave.

    `begin` returns what ends it.
    """

    def __init__(self, begin: Callable[[], Callable[[], Any]]) -> None:
        self._lock, self._count, self._begin = threading.Lock(), 0, begin
        self._end: Callable[[], Any] | None = None

    @contextmanager
    def used(self) -> Iterator[None]:
        """Use it for as long as the context lasts."""
        with self._lock:
            if self._end is None:
                self._end = self._begin()
            self._count += 1
        try:
            yield
        finally:
            with self._lock:
                self._count -= 1
                if self._count == 0 and self._end is not None:
                    self._end()
                    self._end = None


def _quiet() -> Callable[[], Any]:
    blas, usual = _changed(_one_thread_of_blas), cv2.getNumThreads()
    cv2.setNumThreads(1)

    def end() -> None:
        _changed(blas.restore_original_limits)
        cv2.setNumThreads(1 if _alone else usual)

    return end


def _one_thread_of_blas() -> Any:
    """Each BLAS that is loaded by now keeps to one thread; the result restores what was usual."""
    return ThreadpoolController().limit(limits=1)


def _changed(change: Callable[[], Item]) -> Item:
    """Result of a call that changes how many threads BLAS may use.

    In threadpoolctl the first thread that changes it for OpenBLAS is the only one that can,
    until it ends or gives that up: others change nothing, without an error. So whoever it is gives
    it up before, and this thread after the change.
    """
    OpenBLASController.clear_controlling_thread(force=True)
    try:
        return change()
    finally:
        OpenBLASController.clear_controlling_thread(force=True)


def _often() -> Callable[[], Any]:
    usual = sys.getswitchinterval()
    sys.setswitchinterval(_TURN)
    return lambda: sys.setswitchinterval(usual)


_QUIET, _OFTEN = _Counted(_quiet), _Counted(_often)


def one_thread() -> AbstractContextManager[None]:
    """Keep BLAS and OpenCV to one thread each: on what is small theirs wait for each other.

    So OpenCV takes half as long again for a picture of the landmark network with two.
    """
    return _QUIET.used()


def made_within(
    scope: Callable[[], AbstractContextManager[object]], items: Iterable[Item]
) -> Iterator[Item]:
    """The same items, each made within a context of its own, and used outside of it."""
    source = iter(items)
    while True:
        with scope():
            item = next(source, _END)
        if item is _END:
            return
        yield item  # type: ignore[misc]  # never _END


@contextmanager
def closed_after(items: Iterable[Item]) -> Iterator[Iterable[Item]]:
    """Close a generator when the context ends, also by an error: its thread ends with it."""
    try:
        yield items
    finally:
        if isinstance(items, Generator):
            items.close()
