"""Archives of arrays, `.npz`, that name their format and version. Nothing is pickled."""

from __future__ import annotations

import io
import lzma
import tokenize
import zipfile
import zlib
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import InputFileError, ModelFormatError, ParameterError
from abs_engine.core.words import legible
from abs_engine.io.arrays import Layout, check_arrays
from abs_engine.io.files import write_new
from abs_engine.io.inputs import check_file

T = TypeVar("T")
BROKEN = (ValueError, TypeError, OSError, EOFError, RuntimeError, OverflowError, MemoryError,
          zipfile.BadZipFile, zlib.error, lzma.LZMAError, SyntaxError,
          tokenize.TokenError)  # fmt: skip
"""What NumPy and the ZIP reader raise at what is no archive, or one that is cut, damaged,
encrypted, packed in another way, holds pickles, or claims more numbers than any memory holds."""
LARGEST = 1 << 28
"""Bytes that all arrays of a file together may unpack to."""
TIMES = 20
"""What they may unpack to of a larger file, such as the run of an hour: as often its own size."""
MOST_ARRAYS = 1 << 12
"""Arrays in a file."""
_WHOLE = "check that it is whole"
_MESHES = (".glb", ".gltf", ".obj")
_TRIES = 3
_TAKEN = {"format", "version", "file", "allow_pickle"}
"""What the file says itself, and arguments of `numpy.savez_compressed`."""


def read_npz(
    path: Path,
    kind: str,
    version: int,
    layout: Layout | None = None,
    remedy: str = "make it again",
    **lengths: int,
) -> dict[str, NDArray[Any]]:
    """Read an `.npz` that names its `format` and `version`.

    Parameters
    ----------
    layout : mapping of str to Array, optional
        What it must hold; only these arrays are given back. By default all, as they are.
    remedy : str
        What to do if they are not as they must be.
    **lengths : int
        Those that are known already.

    Raises
    ------
    InputFileError
        If the file is missing or no NPZ archive.
    ModelFormatError
        If format or version differ, it holds complex numbers, or not what it must.
    """
    data = read_arrays(path)
    check_format(path, data, kind, version)
    for name, values in data.items():
        if np.iscomplexobj(values):  # NumPy would drop the imaginary parts
            raise ModelFormatError(f"{name!r} in {path} is complex", "give real numbers")
    return data if layout is None else check_arrays(path, data, layout, remedy, **lengths)


def read_model(
    path: Path,
    kind: str,
    version: int,
    make: Callable[[Mapping[str, Any]], T],
    name: str,
    layout: Layout | None = None,
) -> T:
    """Read an `.npz` as `read_npz` does and make a model of its arrays.

    Parameters
    ----------
    make : callable
        Makes the model; `KeyError`, `TypeError`, `ValueError`, `ParameterError` are told as the
        file's fault.
    name : str
        What it should be.

    Raises
    ------
    InputFileError
        If the file is missing or no NPZ archive.
    ModelFormatError
        If it has another format or version, or its arrays make no such model.
    """
    data = read_npz(Path(path), kind, version, layout, "learn it again")
    try:
        return make(data)
    except (LookupError, TypeError, ValueError, ArithmeticError, ParameterError) as error:
        raise ModelFormatError(
            f"{path} does not hold a complete {name}", "learn it again"
        ) from error


def write_npz(path: Path, kind: str, version: int, arrays: Mapping[str, Any]) -> None:
    """Write an `.npz` that `read_npz` reads, compressed, whole or not at all.

    Parameters
    ----------
    path : Path
        Must not exist.
    arrays : mapping of str to array, number, text, or sequences of these
        None of them is called `format`, `version`, `file` or `allow_pickle`.

    Raises
    ------
    OutputError
        If it exists or cannot be written.
    TypeError
        If something would have to be pickled, which `read_npz` refuses.
    ValueError
        If an array has a name that is taken.
    """
    taken = sorted(_TAKEN & arrays.keys())
    if taken:
        raise ValueError(f"no array of an NPZ file can be called '{taken[0]}'")
    fields: dict[str, Any] = {name: _legible(np.asarray(value)) for name, value in arrays.items()}
    pickled = [name for name, value in fields.items() if value.dtype.hasobject]
    if pickled:
        raise TypeError(f"{pickled[0]} is neither numbers nor text")
    memory = io.BytesIO()
    np.savez_compressed(memory, **fields, format=kind, version=version)
    write_new(path, memory.getvalue())


def _legible(values: NDArray[Any]) -> NDArray[Any]:
    """The same with escapes in text that is not UTF-8, as names of files may be."""
    if values.dtype.kind != "U":
        return values
    return np.array([legible(text) for text in values.ravel().tolist()], np.str_).reshape(
        values.shape
    )


def check_format(
    path: Path, data: Mapping[str, NDArray[np.generic]], kind: str, version: int
) -> None:
    """Raise `ModelFormatError` unless the arrays of a file are of a kind and a version."""
    found = format_of(data), _version_of(data)
    if found != (kind, version):
        same = found[0] == kind
        raise ModelFormatError(
            f"{path} is {found[0]} version {found[1]}, wanted {kind} version {version}",
            "make it again with this release" if same else "give a file of that kind",
        )


def format_of(data: Mapping[str, NDArray[np.generic]]) -> str:
    """Stated format of a file; "unknown" where that is missing, or not a line of text."""
    named = data.get("format")
    if named is None or named.ndim or named.dtype.kind != "U":
        return "unknown"
    return str(named) if str(named).isprintable() else "unknown"


def read_kind(path: Path, remedy: str = _WHOLE) -> str:
    """Stated format of an `.npz`, without reading its arrays.

    `remedy` says what to do with a file that is no `.npz`.

    Raises
    ------
    InputFileError
        If the file is missing or no NPZ archive.
    """
    with _archive(path, remedy) as archive:
        named = {"format": _array(archive, "format")} if "format" in archive else {}
    return format_of(named)


def read_some(
    path: Path, kind: str, version: int, wanted: Collection[str] = ()
) -> tuple[tuple[str, ...], dict[str, NDArray[np.generic]]]:
    """Names of all arrays of an `.npz`, and those of them that are wanted.

    Raises
    ------
    InputFileError
        If the file is missing or no NPZ archive.
    ModelFormatError
        If format or version differ.
    """
    with _archive(path) as archive:
        names = tuple(archive.files)
        kept = {"format", "version", *wanted} & set(names)
        data = {name: _array(archive, name) for name in kept}
    check_format(path, data, kind, version)
    return names, data


def _version_of(data: Mapping[str, NDArray[np.generic]]) -> int | str:
    """The version of a file; 0 where it is missing, "unknown" where it is not an integer."""
    told = data.get("version")
    if told is None:
        return 0
    return "unknown" if told.ndim or told.dtype.kind not in "iu" else int(told)


def read_arrays(path: Path) -> dict[str, NDArray[np.generic]]:
    """Read an `.npz` of any making; nothing in it may be pickled.

    Raises
    ------
    InputFileError
        If the file is missing, no NPZ archive, or unpacks to more than `LARGEST` and `TIMES` say.
    """
    with _archive(path) as archive:  # what is no array within it comes as bytes
        data = {name: _array(archive, name) for name in archive.files}
    endless = [name for name, values in data.items() if values.size > LARGEST]  # of no bytes each
    if endless:
        raise InputFileError(f"{endless[0]!r} of {path} has no end", "check where it is from")
    return data


def _array(archive: np.lib.npyio.NpzFile, name: str) -> NDArray[np.generic]:
    """An array of an archive, read again where Python failed to parse its header.

    In early releases of Python 3.11 and 3.12, two threads that parse at once can disturb each
    other's count of nested calls, which raises `SystemError` (CPython issue 106905).
    """
    for _ in range(_TRIES - 1):
        with suppress(SystemError):
            return np.asarray(archive[name])
    return np.asarray(archive[name])


@contextmanager
def _archive(path: Path, remedy: str = _WHOLE) -> Iterator[np.lib.npyio.NpzFile]:
    """An archive to read from; its size is taken from its own directory, before any memory is."""
    check_file(path)
    try:
        with zipfile.ZipFile(path) as directory:
            sizes = [entry.file_size for entry in directory.infolist()]
        if sum(sizes) > max(LARGEST, TIMES * path.stat().st_size) or len(sizes) > MOST_ARRAYS:
            raise InputFileError(
                f"{path} unpacks to {sum(sizes) / 1e9:.1f} GB in {len(sizes)} arrays: too much",
                "check where it is from",
            )
        with np.load(path, allow_pickle=False) as archive:
            yield archive
    except BROKEN as error:
        if path.suffix.lower() in _MESHES:
            raise InputFileError(
                f"{path} is a mesh, not an NPZ file", "make a head of it with 'abs-engine import'"
            ) from error
        raise InputFileError(f"{path} is not an NPZ file", remedy) from error
