"""Kinds of values that are given from Python, where nothing has parsed them."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from numbers import Integral
from pathlib import Path
from typing import Any

from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.core.words import shown

Kind = tuple[Callable[[Any], bool], str]
"""A test of a value, and what to give instead."""


def is_of(*kinds: type) -> Callable[[Any], bool]:
    """Test of whether a value is of some kinds; True and False are not numbers."""
    return lambda value: isinstance(value, kinds) and (not isinstance(value, bool) or bool in kinds)


TEXT: Kind = (is_of(str), "text")
CALLED: Kind = (callable, "a function")
PATH: Kind = (is_of(str, os.PathLike), "a path")
WHOLE: Kind = (is_of(Integral), "a whole number")
_ADDRESS = re.compile(r"[a-z][a-z0-9+.-]*://", re.IGNORECASE)


def check_kind(name: str, value: object, kind: Kind) -> None:
    """Raise `ParameterError` if the value given under a name is of another kind."""
    fits, what = kind
    if not fits(value):
        raise ParameterError(f"{name} is {shown(value)}", f"give {what}")


def checked_frame(frame: int, count: int) -> int:
    """The frame as Python's own number, if it is one of so many; else `ParameterError`."""
    check_kind("frame", frame, WHOLE)
    if not 0 <= frame < count:
        raise ParameterError(f"there is no frame {frame}", f"give 0 to {count - 1}")
    return int(frame)


def to_path(name: str, value: str | os.PathLike[str]) -> Path:
    """The path that was given under a name.

    Raises `ParameterError` if it is not a path, or is empty, and as `check_no_address`.
    """
    check_kind(name, value, PATH)
    if value == "":  # Path would take it for the current folder
        raise ParameterError(f"{name} is empty", "give a path")
    check_no_address(value)
    return Path(value)


def check_no_address(value: str | os.PathLike[str]) -> None:
    """Raise `InputFileError` if a path is an address, such as ``https://...``."""
    if _ADDRESS.match(os.fspath(value)):
        raise InputFileError(f"{value} is an address, not a file", "download it, and give the file")
