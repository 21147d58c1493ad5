"""Output that appears whole or not at all: written beside its place, and named at the end."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import BusyOutputError, OutputError
from abs_engine.io.naming import lock, partial_of, rename_new, sweep


def check_free(path: Path, ending: str = "") -> Path:
    """The path itself, if something new can be named so.

    Parameters
    ----------
    ending : str
        What its name must end in, ".npz", say; small and capital letters are the same.

    Raises
    ------
    OutputError
        If it exists already, there is no folder to put it in, nothing may be written to that, or
        it ends in something else.
    """
    path = Path(path)
    if not path.name.lower().endswith(ending):
        raise OutputError(
            f"{path} does not end in {ending}, which is what is written", "choose a name that does"
        )
    if os.path.lexists(path):
        sweep(path)
        raise OutputError(f"{path} exists already", "choose another name or remove it")
    try:
        there = path.parent.is_dir()
    except OSError as error:
        raise unwritable(path, error) from error
    if not there:
        raise OutputError(
            f"{path} cannot be written: there is no folder {path.parent}",
            "make it or choose another place",
        )
    if not os.access(path.parent, os.W_OK | os.X_OK):  # said before the work, not after it
        read_only = os.statvfs(path.parent).f_flag & os.ST_RDONLY
        number = errno.EROFS if read_only else errno.EACCES
        raise unwritable(path, OSError(number, os.strerror(number)))
    try:
        os.lstat(partial_of(path))  # whose name is longer
    except FileNotFoundError:
        return path
    except OSError as error:
        raise unwritable(path, error) from error
    return path


def next_free(path: Path) -> Path:
    """The path, or the first of path-2, path-3, ... that does not exist."""
    free, number = path, 1
    while free.exists():
        number += 1
        free = path.with_name(f"{path.name}-{number}")
    return free


def write_new(path: Path, content: bytes) -> None:
    """Write a new file, whole or not at all.

    Raises
    ------
    OutputError
        If the file exists or cannot be written, or another process writes it.
    """
    path = check_free(path)
    made = partial_of(path)
    try:
        with os.fdopen(lock(made, os.O_RDWR | os.O_CREAT), "wb") as file:
            try:
                file.truncate()
                file.write(content)
                file.flush()
                rename_new(made, path)
            except BaseException:
                made.unlink()
                raise
    except OSError as error:
        raise unwritable(path, error) from error


@contextmanager
def parent_folder(path: Path) -> Iterator[None]:
    """Make the folder that is to hold `path`; take it away again if the body fails.

    Raises
    ------
    OutputError
        If it cannot be made.
    """
    parent = Path(path).parent
    try:
        parent.mkdir()
    except FileExistsError:
        yield
        return
    except OSError as error:
        raise unwritable(parent, error) from error
    try:
        yield
    except BaseException:
        with suppress(OSError):  # not empty
            parent.rmdir()
        raise


@contextmanager
def scratch() -> Iterator[Path]:
    """A folder for temporary files, removed at the end.

    Raises
    ------
    OutputError
        If they cannot be written.
    """
    try:
        with TemporaryDirectory(prefix="abs_engine-") as folder:
            yield Path(folder)
    except OSError as error:
        where = os.environ.get("TMPDIR", "/tmp")
        raise OutputError(
            f"temporary files cannot be written to {where} ({error.strerror or error})",
            "free space there, or set TMPDIR to another folder",
        ) from error


def png(image: NDArray[np.uint8]) -> bytes:
    """A picture (H, W, 3) uint8 RGB as the bytes of a PNG file."""
    return cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))[1].tobytes()


def unwritable(path: Path, error: OSError) -> OutputError:
    """The error that a user sees when writing to `path` fails."""
    if isinstance(error, BlockingIOError):
        return BusyOutputError(
            f"another process makes {path}", "wait for it, or choose another name"
        )
    if isinstance(error, FileExistsError):
        return OutputError(f"{path} exists already", "choose another name or remove it")
    reason = error.strerror or "writing failed"
    long = error.errno == errno.ENAMETOOLONG
    return OutputError(
        f"{path} cannot be written ({reason})",
        "choose a shorter name" if long else "choose a place of yours, with space left",
    )
