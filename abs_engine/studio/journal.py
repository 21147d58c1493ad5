"""A data set in the making, which survives the process that makes it.

It lies beside its final place as ``.NAME.partial`` and holds the data set's folder as it will be
(``whole``), the plans of the clips (``plans``), the numbers of the chunks that are done
(``chunks``), and ``choices``, which says of which scene it is. A chunk is done when its file in
``chunks`` is there.
"""

from __future__ import annotations

from pathlib import Path

from abs_engine.core.errors import InputFileError
from abs_engine.io.unfinished import Unfinished


class Journal(Unfinished):
    """An unfinished data set; a context manager that holds its lock.

    Parameters
    ----------
    folder : Path
        Where the data set will be; must not exist.
    choices : str
        Digest of all that the data set follows from; '' begins again whatever lies there.

    Raises
    ------
    OutputError
        If the folder exists, its parent cannot be written, an unfinished data set of another
        scene lies there, or somebody works at it right now.
    """

    what = "what another scene, release or command had begun"
    remedy = "give the same scene, seed and release, or remove that folder to begin again"

    def _begin(self) -> None:
        super()._begin()
        for part in (self.plans, self.chunks):
            part.mkdir(exist_ok=True)

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        """Leave; of a file that a crash left in pieces it is said what to remove."""
        super().__exit__(kind, error, trace)
        if isinstance(error, InputFileError) and str(self.partial) in error.problem:
            raise InputFileError(error.problem, f"remove {self.partial} to begin again") from error

    @property
    def plans(self) -> Path:
        """Folder of the clips' plans."""
        return self.partial / "plans"

    @property
    def chunks(self) -> Path:
        """Folder of the numbers of the chunks that are done."""
        return self.partial / "chunks"

    def plan(self, clip: int) -> Path:
        """File of a clip's plan."""
        return self.plans / f"{clip:05d}.npz"

    def done(self, name: str) -> bool:
        """Whether a chunk is done."""
        return (self.chunks / name).is_file()
