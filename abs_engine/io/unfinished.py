"""Folders in the making that survive the process that makes them."""

from __future__ import annotations

import fcntl
import os
from contextlib import suppress
from pathlib import Path

from abs_engine.core.errors import OutputError
from abs_engine.io.files import Making, check_free, give_name, unwritable


class Claim(Making):
    """The place where a folder is made, which no other process may use; a context manager.

    It lies beside the folder's final place as ``.NAME.partial``, and survives the process that
    makes it. Leaving the context lets others have it; what lies there stays.

    Parameters
    ----------
    folder : Path
        What is made: must not exist; its parent must.

    Raises
    ------
    OutputError
        If the folder exists, somebody makes it right now, or its parent cannot be written or
        locked; on leaving the context also for any `OSError` of the writing.
    """

    def __init__(self, folder: Path) -> None:
        self.target = check_free(folder)
        self.work = partial_of(folder)
        try:
            self.work.mkdir(exist_ok=True)
            self._lock: int | None = os.open(self.work, os.O_RDONLY)
        except OSError as error:
            raise unwritable(folder, error) from error
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            self.release()
            if isinstance(error, BlockingIOError):
                remedy = "wait for it, or name another folder"
                raise OutputError(f"another process makes {folder}", remedy) from None
            with suppress(OSError):  # holds what was begun
                self.work.rmdir()
            remedy = "choose a place on a drive of this machine"
            raise OutputError(f"{folder} cannot be locked ({error.strerror})", remedy) from error

    def release(self) -> None:
        """Let others have it; what lies there stays. Again it does nothing."""
        lock, self._lock = self._lock, None
        if lock is not None:
            os.close(lock)

    def leave(self) -> None:
        """Let others have it."""
        self.release()


class Unfinished(Claim):
    """A folder in the making that is gone on with by whoever makes it again; a context manager.

    Made again with the same choices, what was done is found in `work`; only `finish` takes it away.

    Parameters
    ----------
    folder : Path
        Must not exist; its parent must.
    choices : str
        All that the content follows from.

    Raises
    ------
    OutputError
        As by `Claim`, and if other choices began it.
    """

    def __init__(self, folder: Path, choices: str) -> None:
        super().__init__(folder)
        self._basis = self.work / "choices"
        try:
            self._begin(choices)
        except OSError as error:
            self.release()
            raise unwritable(folder, error) from error

    def _begin(self, choices: str) -> None:
        self.resumed = self._basis.is_file()
        if self.resumed and self._basis.read_text(encoding="utf-8") != choices:
            self.release()
            raise OutputError(
                f"{self.work} holds what was begun with other choices",
                "choose the same, or remove that folder to begin again",
            )
        self._basis.write_text(choices, encoding="utf-8")

    def finish(self) -> Path:
        """Give the folder its name, and return it.

        Raises
        ------
        OutputError
            If somebody made the folder in the meantime, or the disk fails.
        """
        try:
            self._basis.unlink()
            give_name(self.work, self.target)
        except OSError as error:
            raise unwritable(self.target, error) from error
        return self.target


def partial_of(folder: Path) -> Path:
    """Where lies what is unfinished of a folder."""
    folder = Path(folder)
    return folder.with_name(f".{folder.name}.partial")
