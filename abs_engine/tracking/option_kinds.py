"""Kinds of values that options take in Python, where nothing has parsed them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np

from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.core.kinds import PATH, TEXT, WHOLE, Kind, check_kind, is_of

PATHS = "speaker", "colours", "physics", "poses"


def term_names(given: str | Sequence[str]) -> tuple[str, ...]:
    """Names of evidence, given as a sequence or joined by +; none where all of them are empty.

    Raises
    ------
    ParameterError
        If one of several is empty.
    """
    names = [name.strip() for name in (given.split("+") if isinstance(given, str) else given)]
    if any(names) and not all(names):
        raise ParameterError(
            f"a name in the terms '{'+'.join(names)}' is empty",
            "write one + between two names, and none at either end",
        )
    return tuple(filter(None, names))


def _holds(values: Any, kind: type) -> bool:
    """Whether a sequence holds values of a kind."""
    several = isinstance(values, Sequence) or (isinstance(values, np.ndarray) and values.ndim > 0)
    return several and all(map(is_of(kind), values))


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
    """Raise `ParameterError` for options of another kind than they take; None is their default.

    So for a name or a path that is empty; of terms see `term_names`.
    """
    for name, kind in _KINDS.items():
        value = options[name]
        if value is not None:
            check_kind(name, value, kind)
        if isinstance(value, str) and name != "terms" and not value.strip():
            raise ParameterError(f"{name} is empty", "give a name, or leave it out")


_KEPT: dict[str, Callable[[Any], Any]] = {
    **dict.fromkeys(PATHS, Path),
    "terms": term_names,
    "model": str,
    "face": int,
    "pupil_distance": float,
    "mouth": lambda box: tuple(map(float, box)),
    "worn": bool,
}


def kept(name: str, given: Any) -> Any:
    """An option's value as it is kept, and written into a run: none of NumPy's own numbers.

    Raises
    ------
    ParameterError
        If a length is too large for a number, or the name of a term is empty.
    """
    try:
        return _KEPT[name](given) if name in _KEPT else given
    except OverflowError as error:
        raise ParameterError(f"{name} is too large for a number", "give millimetres") from error
