"""Kinds of values that are given from Python, where nothing has parsed them."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from abs_engine.core.errors import ParameterError

Kind = tuple[Callable[[Any], bool], str]
"""A test of a value, and what to give instead."""


def is_of(*kinds: type) -> Callable[[Any], bool]:
    """Test of whether a value is of some kinds; True and False are not numbers."""
    return lambda value: isinstance(value, kinds) and (not isinstance(value, bool) or bool in kinds)


TEXT: Kind = (is_of(str), "text")
CALLED: Kind = (callable, "a function")
PATH: Kind = (is_of(str, os.PathLike), "a path")


def check_kind(name: str, value: object, kind: Kind) -> None:
    """Raise `ParameterError` if the value given under a name is of another kind."""
    fits, what = kind
    if not fits(value):
        raise ParameterError(f"{name} is {value!r}", f"give {what}")


def to_path(name: str, value: str | os.PathLike[str]) -> Path:
    """The path that was given under a name.

    Raises
    ------
    ParameterError
        If it is not a path.
    """
    check_kind(name, value, PATH)
    return Path(value)
