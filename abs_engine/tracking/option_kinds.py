"""Kinds of values that options take in Python, where nothing has parsed them."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from numbers import Integral, Real
from typing import Any

import numpy as np

from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError


def _is(*kinds: type) -> Callable[[Any], bool]:
    """Test of whether a value is of some kinds; True and False are no numbers."""
    return lambda value: isinstance(value, kinds) and (not isinstance(value, bool) or bool in kinds)


def _holds(values: Any, kind: type) -> bool:
    """Whether a sequence holds values of a kind."""
    return isinstance(values, Sequence | np.ndarray) and all(map(_is(kind), values))


_TEXT, _PATH = (_is(str), "text"), (_is(str, os.PathLike), "a path")
_KINDS: dict[str, tuple[Callable[[Any], bool], str]] = {
    **dict.fromkeys(("person", "start", "evidence", "driver", "preset", "smooth"), _TEXT),
    **dict.fromkeys(("video", "output", "speaker", "colours", "physics", "poses"), _PATH),
    **dict.fromkeys(("model", "model_file"), _PATH),
    "camera": (_is(str, os.PathLike, Camera), "a path or a Camera"),
    "terms": (lambda terms: _holds(terms, str), "text, or a sequence of text"),
    "face": (_is(Integral), "a whole number"),
    "pupil_distance": (_is(Real), "a number"),
    "mouth": (
        lambda box: _holds(box, Real) and len(box) == 4,
        "four numbers: left, top, width and height",
    ),
    "worn": (_is(bool, np.bool_), "True or False"),
}


def check_kinds(options: Mapping[str, Any]) -> None:
    """Raise `ParameterError` for options of another kind than they take.

    None is their default, but for the video.
    """
    for name, (fits, what) in _KINDS.items():
        value = options.get(name)
        if (value is not None or name == "video") and not fits(value):
            raise ParameterError(f"{name} is {value!r}", f"give {what}")
