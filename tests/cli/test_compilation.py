"""A first run that compiles for long says so, once."""

from __future__ import annotations

import threading

import click
import numba
import pytest
from numba.core import event

from abs_engine.cli.parts import compilation
from abs_engine.cli.parts.compilation import NOTICE, compilation_noticed
from abs_engine.cli.parts.drawing import opened

KIND = "numba:compile"


def fresh():
    """A function that nothing has compiled yet, and calls another."""

    @numba.njit
    def inner(x):
        return x + 1

    @numba.njit
    def outer(x):
        return inner(x) * 2

    return outer


@pytest.fixture
def told():
    return []


@pytest.fixture
def clock(monkeypatch):
    """The time, to be set by hand."""
    now = [0.0]
    monkeypatch.setattr(compilation.time, "perf_counter", lambda: now[0])
    return now


def compiles(clock, seconds, nested=0.0):
    """As if a function were compiled for so long, and within it first another."""
    event.start_event(KIND)
    if nested:
        compiles(clock, nested)
    clock[0] += seconds - nested
    event.end_event(KIND)


def test_seconds_of_all_functions_add_up(told, clock):
    with compilation_noticed(told.append):
        compiles(clock, 0.6)
        assert told == []
        compiles(clock, 0.6)
        assert told == [NOTICE]
        compiles(clock, 5.0)
    assert told == [NOTICE]


def test_what_a_function_calls_is_counted_once_and_while_it_lasts(told, clock):
    with compilation_noticed(told.append):
        compiles(clock, 0.9, nested=0.8)
        assert told == []
        event.start_event(KIND)
        compiles(clock, 0.2)
        assert told == [NOTICE]  # before the outer one is compiled
        event.end_event(KIND)


def test_what_began_before_is_left_alone(told, clock):
    event.start_event(KIND)
    with compilation_noticed(told.append):
        clock[0] += 9.0
        event.end_event(KIND)
    assert told == []


def test_what_is_compiled_already_is_not_said(told, monkeypatch):
    monkeypatch.setattr(compilation, "LEAST", 0.0)
    ready = fresh()
    ready(1)
    with compilation_noticed(told.append):
        ready(1)
        assert told == []
        fresh()(1)
    assert told == [NOTICE]
    with compilation_noticed(told.append):
        pass
    fresh()(2)
    assert told == [NOTICE]


@pytest.mark.parametrize(("option", "said"), [("--json", True), ("--quiet", False), ("", True)])
def test_a_command_says_it_on_stderr_but_for_quiet(option, said, monkeypatch, capsys):
    """Also if another thread compiles, which knows of no command."""
    monkeypatch.setattr(compilation, "LEAST", 0.0)

    @click.command()
    @click.option("--json", is_flag=True)
    @click.option("--quiet", is_flag=True)
    def command(**_):
        with opened("cpu"):
            beside = threading.Thread(target=fresh(), args=(1,))
            beside.start()
            beside.join()

    command([option] if option else [], standalone_mode=False)
    seen = capsys.readouterr()
    assert (NOTICE in seen.err) == said
    assert NOTICE not in seen.out
