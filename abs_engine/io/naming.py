"""Names of new output: given at once over nothing, claimed before the work, remains swept."""

from __future__ import annotations

import ctypes
import errno
import fcntl
import os
import shutil
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path

WHOLE, CHOICES = "whole", "choices"
"""In a folder of what is unfinished: the output as it will be, and all that it follows from."""
RECORD = ".choices"
"""In a finished folder: a digest of all that it follows from, then the names of its files."""
_NOREPLACE = 1  # RENAME_NOREPLACE of renameat2(2)
_HERE = -100  # AT_FDCWD
_UNKNOWN = (errno.ENOSYS, errno.EINVAL)  # of the system, of its kind of disk


def partial_of(path: Path) -> Path:
    """Path of the unfinished part of an output."""
    path = Path(path)
    return path.with_name(f".{path.name}.partial")


def path_from(folder: Path, path: Path) -> str:
    """Path of a file as it is found from a folder, by whatever links either was reached."""
    there = path.parent.resolve() / path.name
    return Path(os.path.relpath(there, folder.resolve())).as_posix()


def rename_new(made: Path, place: Path) -> None:
    """Write a finished file or folder to the disk, and give it a name that nothing has.

    Killed at any moment, it has either name and is whole.

    Raises
    ------
    FileExistsError
        If something has that name.
    """
    settle(made)
    try:
        _rename_only(made, place)
    except OSError as error:
        if error.errno not in _UNKNOWN:
            raise
        if os.path.lexists(place):
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST)) from None
        os.rename(made, place)
    _sync(place.parent)


def settle(path: Path) -> None:
    """Wait until a file, or a folder with all that it holds, is on the disk."""
    if path.is_dir() and not path.is_symlink():
        for inside in path.iterdir():
            settle(inside)
    if not path.is_symlink():
        _sync(path)


def lock(path: Path, flags: int) -> int:
    """Open a path and lock it until it is closed, or the process ends in whatever way.

    Raises
    ------
    BlockingIOError
        If another process has locked it.
    FileNotFoundError
        If it is not there, or another process took it away just now.
    """
    number = os.open(path, flags | os.O_CLOEXEC, 0o666)
    try:
        fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if not os.path.samestat(os.fstat(number), os.stat(path)):
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT))
    except OSError:
        os.close(number)
        raise
    return number


def made_before(path: Path) -> bool:
    """Whether an output is there; what a process killed just then left beside it is taken away."""
    if not os.path.lexists(path):
        return False
    sweep(path)
    return True


def sweep(path: Path) -> None:
    """Take away what a killed process left beside a finished output.

    Kept is what another process works at, and what can still be gone on with.
    """
    if not Path(path).name:  # "." or "/"
        return
    partial = partial_of(path)
    with suppress(OSError):
        number = lock(partial, os.O_RDONLY)
        try:
            if not partial.is_dir():
                partial.unlink()
            elif not is_kept(partial):
                shutil.rmtree(partial)
        finally:
            os.close(number)


def is_kept(partial: Path) -> bool:
    """Whether a folder of what is unfinished can be gone on with.

    Without the output in it, it was finished by a process that was killed just then.
    """
    return (partial / CHOICES).is_file() and (partial / WHOLE).is_dir()


def empty(folder: Path) -> None:
    """Remove all that a folder holds."""
    for inside in folder.iterdir():
        if inside.is_dir() and not inside.is_symlink():
            shutil.rmtree(inside)
        else:
            inside.unlink()


def _sync(path: Path) -> None:
    number = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        os.fsync(number)
    finally:
        os.close(number)


@cache
def _renameat2() -> Callable[..., int] | None:
    """The C library's function; None in one that has none."""
    found: Callable[..., int] | None = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
    return found


def _rename_only(made: Path, place: Path) -> None:
    """Rename if nothing has that name."""
    call = _renameat2()
    if call is None:
        raise OSError(errno.ENOSYS, os.strerror(errno.ENOSYS))
    if call(_HERE, os.fsencode(made), _HERE, os.fsencode(place), _NOREPLACE):
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))
