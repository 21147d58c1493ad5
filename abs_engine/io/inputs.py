"""Input files: checked for being there, and parsed without a raw exception."""

from __future__ import annotations

import codecs
import errno
import json
import math
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeVar

from abs_engine.core.errors import InputFileError

T = TypeVar("T")
MOST = 1e12
"""No number in a file that is read is larger: no length, angle, rate or worth."""
MOST_BYTES = 1 << 29
"""Of a table, text, archive or mesh; pictures and videos have limits of their own."""
DEEPEST = 40
"""Lists and tables of a text file that may lie in each other."""
_NESTED = (dict, list)
_TOO_DEEP = "lists or tables lie in each other too deep"


def is_there(path: Path) -> bool:
    """Whether there is a file or folder of that path.

    Raises
    ------
    InputFileError
        If that cannot be looked up: a folder of its path is locked, or no file can be named so.
    """
    try:
        return path.exists()
    except (OSError, ValueError) as error:
        raise _unreadable(path, error) from error


def check_file(path: Path, remedy: str = "check the path") -> None:
    """Raise `InputFileError` for what is not there, no file, locked, or beyond `MOST_BYTES`."""
    if not is_there(path):
        raise InputFileError(f"{path} does not exist", remedy)
    if not path.is_file():
        raise InputFileError(f"{path} is not a file", remedy)
    if path.stat().st_size > MOST_BYTES:
        raise InputFileError(f"{path} is larger than {MOST_BYTES >> 20} MiB", "give a smaller file")
    try:
        path.open("rb").close()
    except OSError as error:
        raise _unreadable(path, error) from error


def _unreadable(path: Path, error: OSError | ValueError) -> InputFileError:
    reason = getattr(error, "strerror", None) or error
    return InputFileError(
        f"{str(path)!r} cannot be read ({reason})", "check the path, and who may read it"
    )


def read_text(path: Path, remedy: str = "check the path") -> str:
    """Text of a file in UTF-8, with its own ends of lines, without a byte order mark.

    Raises
    ------
    InputFileError
        If it cannot be read, or is no such text; `remedy` says what to do about a file of no text.
    """
    check_file(path)
    content = path.read_bytes()
    try:
        return _decoded(content)
    except ValueError as error:
        wide = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
        if b"\0" in content and not wide:
            raise InputFileError(f"{path} is not text", remedy) from error
        raise InputFileError(f"{path} is not text in UTF-8", "save it as UTF-8") from error


def _decoded(content: bytes) -> str:
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError("it is not text in UTF-8") from error


def parse_json(text: str, *, gaps: bool = False) -> Any:
    """Values of a JSON text.

    Parameters
    ----------
    gaps : bool
        Whether it may hold NaN and infinity, which JSON has not but Python writes.

    Raises
    ------
    ValueError
        If it is no JSON, nested too deep, gives a key twice, of which one would be lost, or holds
        a number that is not finite.
    """
    number = float if gaps else _finite
    try:
        value = json.loads(
            text, object_pairs_hook=_distinct, parse_constant=number, parse_float=number
        )
    except RecursionError as error:
        raise ValueError(_TOO_DEEP) from error
    return _shallow(value)


def read_json(path: Path, *, gaps: bool = False) -> Any:
    """Values of a JSON file; `ValueError` as by `parse_json`, `OSError` if it cannot be read."""
    if not path.is_file() or path.stat().st_size > MOST_BYTES:
        raise OSError(errno.EINVAL, "no ordinary file, or too large", str(path))
    return parse_json(_decoded(path.read_bytes()), gaps=gaps)


def parse_toml(text: str) -> dict[str, Any]:
    """Values of a TOML text.

    Raises
    ------
    ValueError
        If it is no TOML (`tomllib.TOMLDecodeError`), or nested too deep.
    """
    try:
        value = tomllib.loads(text)
    except RecursionError as error:
        raise ValueError(_TOO_DEEP) from error
    return _shallow(value)


def read_toml(path: Path, remedy: str) -> dict[str, Any]:
    """Values of a TOML file.

    Raises
    ------
    InputFileError
        If it cannot be read, or is no TOML; `remedy` says what to do.
    """
    try:
        return parse_toml(read_text(path, remedy))
    except ValueError as error:
        raise InputFileError(f"{path} is not TOML ({error})", remedy) from error


def to_number(cell: str, *, gaps: bool = False) -> float:
    """The number that a cell of a table holds; with `gaps` NaN where it is empty or says so.

    Raises
    ------
    ValueError
        If it holds something else, or what is not finite or larger than `MOST`.
    """
    number = float(cell if cell.strip() or not gaps else "nan")
    within = abs(number) <= MOST or (gaps and math.isnan(number))
    if not within or "_" in cell or not cell.isascii():  # both are numbers to Python
        raise ValueError(f"{cell!r} is not a number that can be used")
    return number


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


def _finite(text: str) -> float:
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"{text} is not a number")
    return number


def _shallow(value: T) -> T:
    """The value itself; `ValueError` if more than `DEEPEST` lists or tables lie in each other."""
    level: list[Any] = [value]
    for _ in range(DEEPEST):
        inner = [v.values() if isinstance(v, dict) else v for v in level if isinstance(v, _NESTED)]
        level = [one for values in inner for one in values]
        if not level:
            return value
    raise ValueError(_TOO_DEEP)
