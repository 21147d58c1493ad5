"""Output that appears whole or not at all: written beside its place, and named at the end."""

from __future__ import annotations

import os
import shutil
import tempfile
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import OutputError


class Making(ABC):
    """Output in the making: however its context is left, it is tidied up, and a failing disk named.

    Attributes
    ----------
    target : Path
        What is made.
    """

    target: Path

    @abstractmethod
    def leave(self) -> None:
        """Tidy up."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.leave()
        if isinstance(error, OSError):
            raise unwritable(self.target, error) from error


class NewFolder(Making):
    """A folder in the making: fill `work`, then `finish` gives it its name.

    Leaving the context without `finish` removes what was written, whatever the reason.

    Parameters
    ----------
    folder : Path
        Must not exist; its parent must.

    Raises
    ------
    OutputError
        If the folder exists or its parent cannot be written; on leaving the context also for any
        `OSError` of the writing.
    """

    def __init__(self, folder: Path) -> None:
        self.target = check_free(folder)
        try:
            made = tempfile.mkdtemp(prefix=f".{self.target.name}-", dir=self.target.parent)
        except OSError as error:
            raise unwritable(folder, error) from error
        self.work = Path(made)

    def finish(self) -> Path:
        """Give the folder its name, and return it.

        Raises
        ------
        OutputError
            If somebody made the folder in the meantime, or the disk fails.
        """
        try:
            self.work.chmod(0o777 & ~_umask())
            give_name(self.work, self.target)
        except OSError as error:
            raise unwritable(self.target, error) from error
        return self.target

    def leave(self) -> None:
        """Remove what was written; nothing happens after `finish`."""
        shutil.rmtree(self.work, ignore_errors=True)


def check_free(path: Path, ending: str = "") -> Path:
    """The path itself, if something new can be named so.

    Parameters
    ----------
    path : Path
    ending : str
        What its name must end in, ".npz", say; small and capital letters are the same.

    Raises
    ------
    OutputError
        If it exists already, there is no folder to put it in, or it ends in something else.
    """
    path = Path(path)
    if not path.name.lower().endswith(ending):
        raise OutputError(
            f"{path} does not end in {ending}, which is what is written",
            "choose a name that does",
        )
    if os.path.lexists(path):
        raise OutputError(f"{path} exists already", "choose another name or remove it")
    if not path.parent.is_dir():
        raise OutputError(
            f"{path} cannot be written: there is no folder {path.parent}",
            "make it or choose another place",
        )
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
        If the file exists or cannot be written.
    """
    path = check_free(path)
    try:
        number, made = tempfile.mkstemp(prefix=f".{path.name}-", dir=path.parent)
        try:
            with os.fdopen(number, "wb") as file:
                file.write(content)
            os.chmod(made, 0o666 & ~_umask())
            os.close(os.open(path, os.O_CREAT | os.O_EXCL))  # fails if there is anything
            _put(Path(made), path, os.unlink)
        except BaseException:
            os.unlink(made)
            raise
    except OSError as error:
        raise unwritable(path, error) from error


def give_name(made: Path, folder: Path) -> None:
    """Make a finished folder the one of that name, which must not exist."""
    os.mkdir(folder)  # fails if there is anything; a rename replaces an empty folder
    _put(made, folder, os.rmdir)


def _put(made: Path, place: Path, remove: Callable[[Path], None]) -> None:
    """Rename over the empty thing that was just made in the place; take that away on failure."""
    try:
        os.rename(made, place)
    except BaseException:
        with suppress(OSError):  # somebody filled it: theirs now
            remove(place)
        raise


@contextmanager
def parent_folder(path: Path) -> Iterator[None]:
    """Make the folder that is to hold `path`; take it away again if the body fails.

    Parameters
    ----------
    path : Path

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


def png(image: NDArray[np.uint8]) -> bytes:
    """A picture (H, W, 3) uint8 RGB as the bytes of a PNG file."""
    return cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))[1].tobytes()


def unwritable(path: Path, error: OSError) -> OutputError:
    """The error that a user sees when writing to `path` fails."""
    if isinstance(error, FileExistsError):
        return OutputError(f"{path} exists already", "choose another name or remove it")
    reason = error.strerror or "writing failed"
    return OutputError(
        f"{path} cannot be written ({reason})", "choose a place of yours, with space left"
    )


def _umask() -> int:
    """The process's file-creation mask; reading it means setting it for an instant."""
    mask = os.umask(0o022)
    os.umask(mask)
    return mask
