"""The table of many clips: ``clips.csv``, whole at every moment."""

from __future__ import annotations

import csv
import io
import os
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from abs_engine.clips.job import TABLE, WAITING, Job, Outcome
from abs_engine.core.clock import TIMING
from abs_engine.core.errors import OutputError
from abs_engine.core.words import legible
from abs_engine.dataset.sums import digest
from abs_engine.io.files import check_free, unwritable
from abs_engine.io.inputs import read_json
from abs_engine.io.naming import lock, partial_of, path_from, settle
from abs_engine.tracking.runs.record import run_settings

COLUMNS = ("clip", "video", "status", "frames", "found", "closed", "message")
_APART = 20
"""Times as long as a table takes to be written that pass, at least, before it is written again."""


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


def rows_of_others(folder: Path, jobs: Iterable[Job]) -> list[list[str]]:
    """Rows of the table for clips of earlier commands; none if it cannot be read as one.

    Raises
    ------
    OutputError
        If a run that is there is of another clip than is to be tracked to it.
    """
    ours = {legible(job.name): job for job in jobs}
    try:
        with (folder / TABLE).open(encoding="utf-8", newline="") as file:
            heading, *rows = csv.reader(file, strict=True)
    except (OSError, ValueError, csv.Error):
        return []
    if any(len(row) != len(COLUMNS) for row in rows) or tuple(heading) != COLUMNS:
        return []
    for name, video, *_ in rows:
        if (
            name in ours
            and video != legible(path_from(folder, ours[name].video))
            and _is_other(ours[name])
        ):
            raise OutputError(
                f"{folder / name} is of {os.path.normpath(folder.resolve() / video)}",
                f"track {ours[name].video} to another folder, or rename that video",
            )
    return [row for row in rows if row[0] not in ours]


def timing_of_others(folder: Path, others: Sequence[Sequence[str]]) -> dict[str, dict[str, Any]]:
    """Seconds and deaths of the clips of these rows, as ``timing.json`` has them."""
    names = {row[0] for row in others}
    try:
        told = read_json(folder / TIMING)
    except (OSError, ValueError):
        told = None
    out = {}
    for key in ("clips", "workers_died"):
        numbers = told.get(key) if isinstance(told, dict) else None
        said = numbers if isinstance(numbers, dict) else {}
        out[key] = {name: number for name, number in said.items() if legible(name) in names}
    return out


class Table:
    """The table of the clips of a command, in the folder of their runs.

    Parameters
    ----------
    others : iterable of rows
        Those before these, see `rows_of_others`.
    """

    def __init__(
        self, folder: Path, jobs: Iterable[Job], others: Iterable[Sequence[str]] = ()
    ) -> None:
        self._path, self._others = folder / TABLE, list(others)
        # once: finding a path takes longer than writing its row
        self._videos = {job.name: path_from(folder, job.video) for job in jobs}
        self._next = 0.0

    def write(self, outcomes: Mapping[str, Outcome]) -> None:
        """Write the table in place of the one before.

        Parameters
        ----------
        outcomes : mapping of str to Outcome
            By the names of the jobs; without one, a clip waits.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        begin, text = time.monotonic(), io.StringIO()
        table = csv.writer(text, lineterminator="\n")
        table.writerow(COLUMNS)
        table.writerows(self._others)
        for name, video in self._videos.items():
            got = outcomes.get(name, Outcome(WAITING))
            counts = got.frames, got.found, got.closed
            table.writerow((name, video, got.status, *counts, got.message))
        made = partial_of(self._path)
        try:
            made.write_text(legible(text.getvalue()), encoding="utf-8")
            settle(made)
            made.replace(self._path)
        except OSError:
            made.unlink(missing_ok=True)
            raise
        end = time.monotonic()
        self._next = end + _APART * (end - begin)

    def refresh(self, outcomes: Mapping[str, Outcome]) -> None:
        """Write it, unless that was done just now: a long table costs no more than a short one."""
        if time.monotonic() >= self._next:
            self.write(outcomes)


def _is_other(job: Job) -> bool:
    """Whether the run of a clip's name is of another."""
    known = run_settings(job.folder).get("video_sha256")
    try:
        return known is not None and digest(job.video) != known
    except OSError:  # it is not there, say
        return True
