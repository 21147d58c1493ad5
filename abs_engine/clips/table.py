"""The table of many clips: ``clips.csv``, whole at every moment."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from abs_engine.clips.job import TABLE, WAITING, Job, Outcome
from abs_engine.core.clock import TIMING
from abs_engine.io.files import check_free, unwritable
from abs_engine.io.naming import lock, partial_of, settle

COLUMNS = ("clip", "video", "status", "frames", "found", "closed", "message")


@contextmanager
def runs_folder(folder: Path) -> Iterator[Path]:
    """The folder of many runs, made if it is not there, for one command at a time.

    What was made is removed if the command fails while nothing is in it.

    Raises
    ------
    OutputError
        If it holds something else, another command works there, or it cannot be written.
    """
    fresh = not os.path.lexists(folder)
    if fresh:
        check_free(folder)
    try:
        folder.mkdir(exist_ok=True)
        files = {path.name for path in folder.iterdir() if not path.is_dir()}
        if files - {partial_of(folder / TABLE).name, TIMING} and TABLE not in files:
            raise FileExistsError  # a run, or something else; folders may be runs
        number = lock(folder, os.O_RDONLY)
    except OSError as error:
        raise unwritable(folder, error) from error
    try:
        yield folder
    except OSError as error:
        raise unwritable(folder, error) from error
    finally:
        os.close(number)
        if fresh:
            with suppress(OSError):  # something is in it
                folder.rmdir()


def write_table(folder: Path, jobs: Iterable[Job], outcomes: Mapping[str, Outcome]) -> None:
    """Write the table in place of the one before.

    Parameters
    ----------
    jobs : iterable of Job
        A row for each.
    outcomes : mapping of str to Outcome
        By the names of the jobs; without one, a clip waits.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(COLUMNS)
    for job in jobs:
        got = outcomes.get(job.name, Outcome(WAITING))
        video = Path(os.path.relpath(job.video, folder.absolute())).as_posix()
        counts = got.frames, got.found, got.closed
        table.writerow((job.name, video, got.status, *counts, got.message))
    made = partial_of(folder / TABLE)
    made.write_text(text.getvalue(), encoding="utf-8", errors="backslashreplace")
    settle(made)
    made.replace(folder / TABLE)
