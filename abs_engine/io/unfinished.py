"""Folders in the making that are gone on with by whoever makes them again."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from abs_engine.core.errors import (
    AbsEngineError,
    OpenGLError,
    OutputError,
    SameOutputError,
    StudioError,
)
from abs_engine.io.files import check_free
from abs_engine.io.naming import CHOICES, RECORD, empty, is_kept, rename_new, sweep
from abs_engine.io.new_folder import NewFolder

_MACHINE = OutputError, OpenGLError, StudioError
"""Errors after which the same command may succeed."""


class Unfinished(NewFolder):
    """A folder in the making that is gone on with by whoever makes it again; a context manager.

    Made again with the same choices, what was done is found in `work`; `finish` and `discard` take
    it away, but leaving the context does not.

    Parameters
    ----------
    folder : Path
        Must not exist; its parent must.
    choices : str
        All that the content follows from; '' begins again whatever lies there.
    anew : str
        The command, if what it began with other choices is removed; else that is an error, as what
        other commands began is, unless `choices` is ''.
    also : str
        Choices that what was begun may be gone on with by others, but that its end follows from.
    by : str
        What draws, say: only the same goes on with what was begun, but what is finished is known
        on every machine.

    Attributes
    ----------
    resumed : bool
        Whether something is gone on with.
    replaced : bool
        Whether what was begun with other choices was removed.

    Raises
    ------
    OutputError
        As by `NewFolder`, and if other choices began it.
    SameOutputError
        If the folder exists, made with the same choices, with all the files that it had.
    """

    def __init__(
        self, folder: Path, choices: str, anew: str = "", also: str = "", by: str = ""
    ) -> None:
        self._choices, self._anew, self._also = choices, anew, also
        self.resumed = self.replaced = False
        self._basis = f"{anew}\n{choices}\n{by}" if choices else ""
        super().__init__(folder)

    def _check(self) -> None:
        """Refuse a name that is taken; by another error, if by what would be made."""
        if is_recorded(self.target) and self._choices:
            sweep(self.target)
            made = (self.target / RECORD).read_text("utf-8", "replace").split("\n")
            now = self._record(self.target)
            if made[0] == now[0] and set(made) <= set(now):
                raise SameOutputError(
                    f"{self.target} already exists and is complete (made by this same command)",
                    "delete it to run again",
                )
            gone = [name for name in made[1:] if name and name not in now]
            why = "made of other input, with other options or by another release"
            if made[0] == now[0] and gone:
                why = f"made by the same command, but {gone[0]} is missing from it"
            raise OutputError(
                f"{self.target} exists already, {why}", "choose another name or remove it"
            )
        super()._check()

    def _record(self, folder: Path) -> list[str]:
        """Lines of the record of a folder."""
        follows_from = hashlib.sha256(f"{self._choices}\n{self._also}".encode()).hexdigest()
        files = (path for path in folder.rglob("*") if path.is_file())
        names = sorted(path.relative_to(folder).as_posix() for path in files)
        return [follows_from, *(name for name in names if name != RECORD)]

    def finish(self) -> Path:
        """Give the folder its name, with a record of what it follows from, and return it.

        Raises
        ------
        OutputError
            If somebody made the folder in the meantime, or the disk fails.
        """
        if self._choices:
            (self.work / RECORD).write_text("\n".join(self._record(self.work)), encoding="utf-8")
        return super().finish()

    def _begin(self) -> None:
        basis = self.partial / CHOICES
        if is_kept(self.partial):
            begun = basis.read_text(encoding="utf-8")
            self.resumed = begun == self._basis != ""
            own = self._anew and begun.startswith(f"{self._anew}\n")
            if begun and self._choices and not (self.resumed or own):
                super()._begin()  # which refuses it
            self.replaced = not self.resumed and begun != ""
        if not self.resumed:
            self._begin_again()
            made = basis.with_name(f".{CHOICES}")
            made.write_text(self._basis, encoding="utf-8")
            rename_new(made, basis)

    def empty(self) -> None:
        """Remove the output as far as it was made; what lies beside it stays."""
        empty(self.work)

    def leave(self) -> None:
        """Let others have it; what lies there stays."""
        self.release()

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        """Leave; who interrupts it learns what is kept."""
        kept = self._lock is not None
        super().__exit__(kind, error, trace)
        if kept and isinstance(error, KeyboardInterrupt):
            raise KeyboardInterrupt(
                f"what was done is kept in {self.partial}; the same command resumes there"
            ) from None


def is_recorded(folder: Path) -> bool:
    """Whether a folder holds a record of what it follows from."""
    return os.path.isfile(Path(folder) / RECORD)


def check_output(folder: Path) -> None:
    """Refuse a name that is taken, unless the same command may have made what is there.

    Which is seen by `Unfinished`, once all that it follows from is known.

    Raises
    ------
    OutputError
        As `abs_engine.io.files.check_free`.
    """
    if not is_recorded(folder):
        check_free(folder)


@contextmanager
def kept_if_of_use(made: Unfinished, done: Path) -> Iterator[None]:
    """Remove what was made if the body fails, unless the same command could go on with it.

    Parameters
    ----------
    done : Path
        Of use if it is there; a folder, if the output or it holds something.
    """
    try:
        yield
    except BaseException as error:
        input_at_fault = isinstance(error, AbsEngineError) and not isinstance(error, _MACHINE)
        of_use = done.is_file()
        if done.is_dir():
            of_use = any(inside for folder in (done, made.work) for inside in folder.iterdir())
        if input_at_fault or not of_use:
            made.discard()
        raise
