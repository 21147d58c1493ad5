"""Files of the sessions that `observe_session` and `studio_session` film."""

from __future__ import annotations

import csv
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path


def write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> Path:
    """Write a table, and give its path back."""
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([header, *rows])
    return path


@contextmanager
def film_folder(keep: Path | None) -> Iterator[Path]:
    """Where films go: into a new folder `keep`, or one that does not outlive the context."""
    if keep is not None:
        keep.mkdir()
        yield keep
        return
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder)
