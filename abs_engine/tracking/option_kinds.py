"""Kinds of values that options take in Python, where nothing has parsed them."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from numbers import Integral, Real
from typing import Any

import numpy as np

from abs_engine.core.camera import Camera
from abs_engine.core.kinds import CALLED, PATH, TEXT, Kind, check_kind, is_of


def _holds(values: Any, kind: type) -> bool:
    """Whether a sequence holds values of a kind."""
    return isinstance(values, Sequence | np.ndarray) and all(map(is_of(kind), values))


_KINDS: dict[str, Kind] = {
    **dict.fromkeys(("person", "start", "evidence", "driver", "preset", "smooth"), TEXT),
    **dict.fromkeys(("video", "output", "speaker", "colours", "physics", "poses"), PATH),
    **dict.fromkeys(("model", "model_file"), PATH),
    "camera": (is_of(str, os.PathLike, Camera), "a path or a Camera"),
    "terms": (lambda terms: _holds(terms, str), "text, or a sequence of text"),
    "face": (is_of(Integral), "a whole number"),
    "pupil_distance": (is_of(Real), "a number"),
    "mouth": (
        lambda box: _holds(box, Real) and len(box) == 4,
        "four numbers: left, top, width and height",
    ),
    **dict.fromkeys(("progress", "stage"), CALLED),
    "worn": (is_of(bool, np.bool_), "True or False"),
}


def check_kinds(options: Mapping[str, Any]) -> None:
    """Raise `ParameterError` for options of another kind than they take.

    None is their default, but for the video.
    """
    for name, kind in _KINDS.items():
        value = options.get(name)
        if value is not None or name == "video":
            check_kind(name, value, kind)
