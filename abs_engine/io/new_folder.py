"""Folders in the making: nobody else makes them meanwhile, and they appear whole or not at all."""

from __future__ import annotations

import os
import shutil
from contextlib import suppress
from pathlib import Path
from typing import Self

from abs_engine.core.errors import OutputError
from abs_engine.io.files import check_free, unwritable
from abs_engine.io.naming import CHOICES, WHOLE, empty, is_kept, lock, partial_of, rename_new, sweep

_TRIES = 10


class NewFolder:
    """A folder in the making: fill `work`, then `finish` gives it its name.

    It lies beside its place in ``.NAME.partial``, which is locked as long as the process lives;
    what a killed process left there is taken away first, unless it can be gone on with. Leaving
    the context without `finish` removes what was written, whatever the reason.

    Parameters
    ----------
    folder : Path
        Must not exist; its parent must.

    Attributes
    ----------
    partial : Path
        Holds `work`, and what else is to be known until it is finished.

    Raises
    ------
    OutputError
        If the folder exists, another process makes it right now, an interrupted command keeps
        there what it has done, or its parent cannot be written or locked; on leaving the context
        also for any `OSError` of the writing.
    """

    what = "what an interrupted command had kept"
    remedy = "finish it by the same command, choose another name, or remove that folder"
    """What is said of work that can be continued, and what to do."""

    def __init__(self, folder: Path) -> None:
        self.target = Path(folder)
        self._check()
        self.partial = partial_of(folder)
        self.work = self.partial / WHOLE
        self._lock: int | None = self._claimed()
        try:
            self._check()  # another process may have finished it just now
            self._begin()
        except OSError as error:
            if not (self.partial / CHOICES).is_file():  # nothing was kept there before
                self.discard()
            self.release()
            raise unwritable(folder, error) from error
        except BaseException:
            self.release()
            sweep(self.target)
            raise

    def _check(self) -> None:
        """Refuse a name that is taken."""
        check_free(self.target)

    def _claimed(self) -> int:
        for _ in range(_TRIES):
            try:
                self.partial.mkdir(exist_ok=True)
            except OSError as error:
                raise unwritable(self.target, error) from error
            try:
                return lock(self.partial, os.O_RDONLY)
            except FileNotFoundError:  # another process has just finished, or given up
                continue
            except BlockingIOError as error:
                raise unwritable(self.target, error) from None
            except OSError as error:
                with suppress(OSError):  # holds what was begun
                    self.partial.rmdir()
                remedy = "choose a place on a drive of this machine"
                said = f"{self.target} cannot be locked ({error.strerror})"
                raise OutputError(said, remedy) from error
        raise unwritable(self.target, BlockingIOError())

    def _begin(self) -> None:
        """Make ready what is filled."""
        if is_kept(self.partial):
            raise OutputError(f"{self.partial} holds {self.what}", self.remedy)
        self._begin_again()

    def _begin_again(self) -> None:
        """Make ready what is filled, whatever lies there."""
        empty(self.partial)
        self.work.mkdir()

    def finish(self) -> Path:
        """Give the folder its name, and return it.

        Raises
        ------
        OutputError
            If somebody made the folder in the meantime, or the disk fails.
        """
        try:
            rename_new(self.work, self.target)
        except OSError as error:
            raise unwritable(self.target, error) from error
        self.discard()
        return self.target

    def discard(self) -> None:
        """Remove all that was made, and let others have it; nothing happens after `finish`."""
        if self._lock is not None:
            shutil.rmtree(self.partial, ignore_errors=True)
        self.release()

    def release(self) -> None:
        """Let others have it; what lies there stays. Again it does nothing."""
        number, self._lock = self._lock, None
        if number is not None:
            os.close(number)

    def leave(self) -> None:
        """Remove what was written."""
        self.discard()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        self.leave()
        if isinstance(error, OSError):
            raise unwritable(self.target, error) from error
