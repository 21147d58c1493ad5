"""Kinds of values that options take in Python, where nothing has parsed them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from numbers import Integral, Real
from typing import Any

from abs_engine.core.errors import ParameterError

_TEXT, _PATH = (str, "a text"), ((str, os.PathLike), "a path")
_KINDS: dict[str, tuple[Any, str]] = {
    **dict.fromkeys(("person", "start", "evidence", "driver", "preset", "smooth"), _TEXT),
    **dict.fromkeys(("video", "speaker", "colours", "physics", "poses", "model", "output"), _PATH),
    "face": (Integral, "a whole number"),
    "pupil_distance": (Real, "a number"),
    "worn": (bool, "True or False"),
}


def check_kinds(options: Mapping[str, Any]) -> None:
    """Raise `ParameterError` for options of another kind than they take.

    None is their default, but for the video.
    """
    for name, value in options.items():
        kind, what = _KINDS.get(name, (object, ""))
        if not isinstance(value, kind) and (value is not None or name == "video"):
            _refuse(name, what, value)
    mouth = options.get("mouth")
    if mouth is not None and not _four_numbers(mouth):
        _refuse("mouth", "four numbers: left, top, width and height", mouth)


def _four_numbers(value: Any) -> bool:
    try:
        given = tuple(value)
    except TypeError:
        return False
    return len(given) == 4 and all(isinstance(one, Real) for one in given)


def _refuse(name: str, what: str, value: Any) -> None:
    raise ParameterError(f"{name} is {value!r}", f"give {what}")
