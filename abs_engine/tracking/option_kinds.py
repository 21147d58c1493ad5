"""Kinds of values that options take in Python, where nothing has parsed them."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from numbers import Integral, Real
from typing import Any

import numpy as np

from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError

_TEXT, _PATH = ((str,), "text"), ((str, os.PathLike), "a path")
_KINDS: dict[str, tuple[tuple[Any, ...], str]] = {
    **dict.fromkeys(("person", "start", "evidence", "driver", "preset", "smooth"), _TEXT),
    **dict.fromkeys(("video", "output", "speaker", "colours", "physics", "poses"), _PATH),
    **dict.fromkeys(("model", "model_file"), _PATH),
    "camera": ((str, os.PathLike, Camera), "a path or a Camera"),
    "terms": ((str, Sequence), "text, or a sequence of text"),
    "face": ((Integral,), "a whole number"),
    "pupil_distance": ((Real,), "a number"),
    "worn": ((bool, np.bool_), "True or False"),
}
_MOUTH = "four numbers: left, top, width and height"


def check_kinds(options: Mapping[str, Any]) -> None:
    """Raise `ParameterError` for options of another kind than they take.

    None is their default, but for the video.
    """
    for name, value in options.items():
        kinds, what = _KINDS.get(name, ((object,), ""))
        if value is None and name != "video":
            continue
        truth = isinstance(value, bool | np.bool_) and "number" in what
        raw = isinstance(value, bytes) and name == "terms"
        if not isinstance(value, kinds) or truth or raw:
            _refuse(name, what, value)
    mouth, terms = options.get("mouth"), options.get("terms")
    if mouth is not None and not _of(mouth, (Real,), 4):
        _refuse("mouth", _MOUTH, mouth)
    if terms is not None and not _of(terms, (str,), None):
        _refuse("terms", _KINDS["terms"][1], terms)


def _of(values: Any, kinds: tuple[Any, ...], count: int | None) -> bool:
    """Whether a sequence holds values of some kinds, `count` of them."""
    if not isinstance(values, Sequence | np.ndarray):
        return False
    return len(values) == (count or len(values)) and all(isinstance(one, kinds) for one in values)


def _refuse(name: str, what: str, value: Any) -> None:
    raise ParameterError(f"{name} is {value!r}", f"give {what}")
