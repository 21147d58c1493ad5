"""Input files: checked for being there, and parsed without a raw exception."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from abs_engine.core.errors import InputFileError

_TOO_DEEP = "lists or tables lie in each other too deep"


def check_file(path: Path, remedy: str = "check the path") -> None:
    """Raise `InputFileError` for what is not there, and for what is there but no file."""
    if not path.is_file():
        what = "is not a file" if path.exists() else "does not exist"
        raise InputFileError(f"{path} {what}", remedy)


def parse_json(text: str) -> Any:
    """Values of a JSON text.

    Raises
    ------
    ValueError
        If it is no JSON, nested too deep, or gives a key twice, of which one would be lost.
    """
    try:
        return json.loads(text, object_pairs_hook=_distinct)
    except RecursionError as error:
        raise ValueError(_TOO_DEEP) from error


def parse_toml(text: str) -> dict[str, Any]:
    """Values of a TOML text.

    Raises
    ------
    ValueError
        If it is no TOML (`tomllib.TOMLDecodeError`), or nested too deep.
    """
    try:
        return tomllib.loads(text)
    except RecursionError as error:
        raise ValueError(_TOO_DEEP) from error


def name_problem(what: str, name: str) -> str | None:
    """Reason why a name cannot be shown in one line, or None: it is empty, or not all printable."""
    if not name.strip():
        return f"a {what} has an empty name"
    if not name.isprintable():
        return f"the name of the {what} {name!r} has characters that cannot be printed"
    return None


def _distinct(pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    out = dict(pairs)
    if len(out) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for k, name in enumerate(names) if name in names[:k])
        raise ValueError(f"{twice!r} is given twice")
    return out
