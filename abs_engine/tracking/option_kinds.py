"""Kinds of values that options take in Python, where nothing has parsed them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any

import numpy as np

from abs_engine.core.camera import Camera
from abs_engine.core.kinds import PATH, TEXT, WHOLE, Kind, check_kind, is_of

PATHS = "speaker", "colours", "physics", "poses"


def _holds(values: Any, kind: type) -> bool:
    """Whether a sequence holds values of a kind."""
    return isinstance(values, Sequence | np.ndarray) and all(map(is_of(kind), values))


_KINDS: dict[str, Kind] = {
    **dict.fromkeys(("person", "start", "evidence", "driver", "preset", "smooth"), TEXT),
    **dict.fromkeys((*PATHS, "model", "model_file"), PATH),
    "camera": (is_of(Camera), "a Camera"),
    "terms": (lambda terms: _holds(terms, str), "text, or a sequence of text"),
    "face": WHOLE,
    "pupil_distance": (is_of(Real), "a number"),
    "mouth": (
        lambda box: _holds(box, Real) and len(box) == 4,
        "four numbers: left, top, width and height",
    ),
    "worn": (is_of(bool, np.bool_), "True or False"),
}


def check_kinds(options: Mapping[str, Any]) -> None:
    """Raise `ParameterError` for options of another kind than they take; None is their default."""
    for name, kind in _KINDS.items():
        if options[name] is not None:
            check_kind(name, options[name], kind)
