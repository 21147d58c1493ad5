"""A first run that compiles for long says so, once."""

from __future__ import annotations

import numba
import pytest

from abs_engine.cli import compilation
from abs_engine.cli.compilation import NOTICE, compilation_noticed


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


def test_what_takes_long_is_said_once(told, monkeypatch):
    monkeypatch.setattr(compilation, "LEAST", 0.0)
    with compilation_noticed(told.append):
        assert fresh()(1) == 4
        assert fresh()(2.0) == 6.0
    assert told == [NOTICE]


def test_what_is_compiled_already_or_quickly_is_not(told, monkeypatch):
    ready = fresh()
    ready(1)
    monkeypatch.setattr(compilation, "LEAST", 0.0)
    with compilation_noticed(told.append):
        ready(1)
    monkeypatch.setattr(compilation, "LEAST", 1e6)
    with compilation_noticed(told.append):
        fresh()(1)
    assert told == []


def test_afterwards_nothing_listens(told, monkeypatch):
    monkeypatch.setattr(compilation, "LEAST", 0.0)
    with compilation_noticed(told.append):
        pass
    fresh()(1)
    assert told == []
