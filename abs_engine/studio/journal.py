"""A data set in the making, which survives the process that makes it.

It lies beside its final place as ``.NAME.partial`` and holds the data set's folder as it will be
(``dataset``), the plans of the clips (``plans``), the numbers of the chunks that are done
(``chunks``), and ``journal.json``, which tells of which scene it is. A chunk is done when its file
in ``chunks`` is there.
"""

from __future__ import annotations

import json
import os
import shutil
from pathlib import Path

from abs_engine.core.errors import OutputError
from abs_engine.io.files import check_free, give_name, unwritable
from abs_engine.io.unfinished import Claim

FORMAT, VERSION = "abs_engine.journal", 1
_REMEDY = "give the same scene, seed and release, or remove that folder to begin again"


class Journal(Claim):
    """An unfinished data set; a context manager that holds its lock.

    Parameters
    ----------
    folder : Path
        Where the data set will be; must not exist.
    scene : str
        Digest of all that the data set follows from; '' begins again whatever lies there.

    Raises
    ------
    OutputError
        If the folder exists, its parent cannot be written, an unfinished data set of another
        scene lies there, or somebody works at it right now.
    """

    def __init__(self, folder: Path, scene: str) -> None:
        super().__init__(folder)
        try:
            self.resumed = bool(scene) and (self.work / "journal.json").is_file()
            if not self.resumed:
                self._clear()
            for part in (self.dataset, self.plans, self.chunks):
                part.mkdir(exist_ok=True)
            if self.resumed:
                self._check(scene)
            else:
                told = {"format": FORMAT, "version": VERSION, "scene": scene}
                self._write("journal.json", json.dumps(told) + "\n")
        except OSError as error:
            self.release()
            raise unwritable(folder, error) from error

    @property
    def dataset(self) -> Path:
        """The data set's folder as it will be."""
        return self.work / "dataset"

    @property
    def plans(self) -> Path:
        """Folder of the clips' plans."""
        return self.work / "plans"

    @property
    def chunks(self) -> Path:
        """Folder of the numbers of the chunks that are done."""
        return self.work / "chunks"

    def plan(self, clip: int) -> Path:
        """File of a clip's plan."""
        return self.plans / f"{clip:05d}.npz"

    def done(self, name: str) -> bool:
        """Whether a chunk is done."""
        return (self.chunks / name).is_file()

    def finish(self) -> Path:
        """Give the data set its name, and return it.

        Raises
        ------
        OutputError
            If somebody made the folder in the meantime, or the disk fails.
        """
        check_free(self.target)
        try:
            give_name(self.dataset, self.target)
        except OSError as error:
            raise unwritable(self.target, error) from error
        self.discard()
        return self.target

    def discard(self) -> None:
        """Remove all that was made."""
        shutil.rmtree(self.work, ignore_errors=True)

    def _clear(self) -> None:
        for part in self.work.iterdir():
            if part.is_dir():
                shutil.rmtree(part)
            else:
                part.unlink()

    def _check(self, scene: str) -> None:
        try:
            told = json.loads((self.work / "journal.json").read_text(encoding="utf-8"))
            same = (told["format"], told["version"], told["scene"]) == (FORMAT, VERSION, scene)
        except (ValueError, KeyError, TypeError):
            same = False
        if not same:
            self.release()
            raise OutputError(f"{self.work} holds an unfinished data set of another scene", _REMEDY)

    def _write(self, name: str, text: str) -> None:
        made = self.work / f".{name}"
        made.write_text(text, encoding="utf-8")
        os.replace(made, self.work / name)
