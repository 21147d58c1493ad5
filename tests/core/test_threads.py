"""Work beside other work keeps its order, its errors and its bounds."""

from __future__ import annotations

import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import cv2
import pytest
from threadpoolctl import ThreadpoolController, threadpool_info, threadpool_limits

from abs_engine.core.clock import Clock
from abs_engine.core.threads import Behind, ahead, begin, closed_after, in_threads, kept, one_thread


def test_items_come_as_they_are_from_another_thread():
    makers = []

    def made():
        for k in range(20):
            makers.append(threading.current_thread())
            yield k

    assert list(ahead(made(), 3)) == list(range(20))
    assert threading.current_thread() not in makers


def test_no_more_is_made_than_may_wait():
    made = []
    items = ahead((made.append(k) or k for k in range(100)), 3)
    assert next(items) == 0
    time.sleep(0.05)
    assert len(made) <= 5
    items.close()
    count = len(made)
    time.sleep(0.05)
    assert len(made) <= count + 1


def test_an_error_comes_where_its_item_would():
    def broken():
        yield 1
        raise ValueError("second")

    items = ahead(broken())
    assert next(items) == 1
    with pytest.raises(ValueError, match="second"):
        next(items)


def test_what_is_begun_goes_on_beside_what_follows():
    here, done = threading.current_thread(), threading.Event()
    worker = []

    def work():
        worker.append(threading.current_thread())
        done.set()

    begin(work)
    assert done.wait(5)
    assert worker[0] is not here


def test_an_error_of_what_is_begun_disturbs_nobody(capfd):
    done = threading.Event()

    def work():
        done.set()
        raise ValueError("nobody hears this")

    begin(work)
    assert done.wait(5)
    again = threading.Event()
    begin(again.set)
    assert again.wait(5)
    assert in_threads(str, [1, 2, 3]) == ["1", "2", "3"]
    assert capfd.readouterr().err == ""


def test_on_one_core_nothing_is_begun(monkeypatch):
    monkeypatch.setattr("abs_engine.core.threads._alone", True)
    called = threading.Event()
    begin(called.set)
    assert not called.wait(0.1)


def test_what_is_kept_is_made_by_one_thread():
    made = []

    @kept
    def slow(k):
        made.append(k)
        time.sleep(0.05)
        return [k]

    found = in_threads(slow, [3, 3])
    assert made == [3]
    assert found[0] is found[1]
    assert slow(4) == [4]


def test_calls_are_made_in_their_order_and_waited_for():
    done = []
    with Behind(2) as behind:
        for k in range(10):
            behind.call(done.append, k)
    assert done == list(range(10))


def test_a_call_that_fails_is_not_swallowed():
    def fails():
        raise OSError("full")

    with pytest.raises(OSError, match="full"), Behind() as behind:
        behind.call(fails)


def test_items_are_worked_on_at_once_and_come_in_their_order():
    both = threading.Barrier(2, timeout=5)

    def met(k):
        both.wait()
        return k, threading.current_thread()

    found = in_threads(met, range(4))
    assert [k for k, _ in found] == [0, 1, 2, 3]
    assert len({thread for _, thread in found}) == 2


def test_threads_are_kept_and_not_waited_for_from_within():
    def inner(_):
        return threading.current_thread()

    def outer(_):
        return threading.current_thread(), set(in_threads(inner, range(3)))

    for _ in range(3):
        for own, others in in_threads(outer, range(4)):
            assert others == {own}
    beside = [t for t in threading.enumerate() if t.name.startswith("beside")]
    assert 1 <= len(beside) <= 4


def test_the_first_items_error_is_raised_and_no_more_are_begun():
    begun = []

    def fails(k):
        begun.append(k)
        raise ValueError(str(k))

    with pytest.raises(ValueError, match="0"):
        in_threads(fails, range(50))
    assert len(begun) <= 2


@pytest.fixture
def _two_of_blas():
    """Two threads of each BLAS, as of a user with two cores; tests usually have one."""

    def in_passing(what):
        with ThreadPoolExecutor(1) as pool:
            return pool.submit(what).result()

    limits = in_passing(lambda: ThreadpoolController().limit(limits=2))
    assert set(threads()) == {2}
    yield
    in_passing(limits.restore_original_limits)


def threads():
    """How many threads each BLAS that is loaded may use."""
    return [one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"]


@pytest.mark.usefixtures("_two_of_blas")
def test_one_thread_of_blas_until_the_last_lets_it_go():
    before, of_opencv = threads(), cv2.getNumThreads()
    outer, inner = one_thread(), one_thread()
    outer.__enter__()
    inner.__enter__()
    assert set(threads()) == {1}
    assert cv2.getNumThreads() == 1
    outer.__exit__(None, None, None)
    assert set(threads()) == {1}
    inner.__exit__(None, None, None)
    assert threads() == before
    assert cv2.getNumThreads() == of_opencv


@pytest.mark.usefixtures("_two_of_blas")
def test_one_thread_of_blas_also_after_another_thread_that_still_lives_had_asked_for_it():
    before = threads()
    with ThreadPoolExecutor(1) as other:
        context = one_thread()
        other.submit(context.__enter__).result()
        assert set(threads()) == {1}
        other.submit(context.__exit__, None, None, None).result()
        assert threads() == before
        with one_thread():
            assert set(threads()) == {1}
            inner = one_thread()
            other.submit(inner.__enter__).result()
        assert set(threads()) == {1}  # the other one's
        other.submit(inner.__exit__, None, None, None).result()
        assert threads() == before


@pytest.mark.usefixtures("_two_of_blas")
def test_one_thread_of_blas_also_within_limits_of_a_users_own():
    with threadpool_limits(3):
        with one_thread():
            assert set(threads()) == {1}
        assert set(threads()) == {3}
    assert set(threads()) == {2}


def test_time_is_counted_where_it_is_spent():
    spent = Clock(time.thread_time)
    with spent.part("work"):
        end = time.thread_time() + 0.02
        while time.thread_time() < end:
            pass
    with spent.part("rest"):
        time.sleep(0.02)
    assert spent.seconds["work"] >= 0.02 > spent.seconds["rest"]


def test_a_generator_is_closed_where_its_user_fails():
    ended = []

    def made():
        try:
            yield from range(10)
        finally:
            ended.append(True)

    def fails():
        with closed_after(made()) as items:
            next(iter(items))
            raise OSError("full")

    with pytest.raises(OSError, match="full"):
        fails()
    assert ended == [True]


def test_threads_take_turns_often_until_the_last_is_done():
    usual = sys.getswitchinterval()
    first, second = ahead(iter(range(9))), ahead(iter(range(9)))
    next(first), next(second)
    assert sys.getswitchinterval() < usual
    first.close()
    assert sys.getswitchinterval() < usual
    second.close()
    assert sys.getswitchinterval() == pytest.approx(usual)


def test_the_time_that_items_take_is_counted():
    spent = Clock(time.thread_time)

    def slow():
        for k in range(3):
            end = time.thread_time() + 0.01
            while time.thread_time() < end:
                pass
            yield k

    assert list(spent.over("made", slow())) == [0, 1, 2]
    assert spent.seconds["made"] >= 0.03
