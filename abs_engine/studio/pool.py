"""Films chunks in several processes."""

from __future__ import annotations

import json
import os
import queue
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

from abs_engine.core import errors
from abs_engine.core.errors import StudioError
from abs_engine.core.foreign import last_words
from abs_engine.io.assets import Speaker
from abs_engine.studio.chunk import Job
from abs_engine.studio.journal import Journal

Advance = Callable[[], None]
_REMEDY = "free some memory, or film with fewer processes; the same command continues"


def film_apart(
    jobs: list[Job],
    journal: Journal,
    speaker: Speaker,
    labels: tuple[str, ...],
    advance: Advance,
    processes: int,
) -> None:
    """Film chunks in several processes, which read the bundled head themselves.

    Raises
    ------
    StudioError
        If a process ends before its time.
    AbsEngineError
        What went wrong in a process.
    """
    left = list(jobs)
    told: queue.Queue[tuple[_Film, dict[str, Any]]] = queue.Queue()
    with ExitStack() as stack:
        films = [
            stack.enter_context(_Film(journal.partial, speaker, labels, told))
            for _ in range(min(processes, len(jobs)))
        ]
        for film in films:
            film.start(_next(left, film, films))
        busy = len(films)
        while busy:
            film, message = told.get()
            if "error" in message:
                name, problem, remedy = message["error"]
                raise getattr(errors, name, StudioError)(problem, remedy)
            if "frame" in message:
                advance()
                continue
            if left:
                film.start(_next(left, film, films))
            else:
                film.job = None
                busy -= 1


def _next(left: list[Job], film: _Film, films: list[_Film]) -> Job:
    """Take the job that suits a process: of the camera it has, else of one that nobody has."""
    taken = {(f.job.clip, f.job.view) for f in films if f.job is not None and f is not film}
    own = None if film.job is None else (film.job.clip, film.job.view)

    def cost(job: Job) -> tuple[bool, bool, Job]:
        return (job.clip, job.view) != own, (job.clip, job.view) in taken, job

    job = min(left, key=cost)
    left.remove(job)
    return job


class _Film:
    """A process that films; a context manager that ends it."""

    def __init__(
        self,
        work: Path,
        speaker: Speaker,
        labels: tuple[str, ...],
        told: queue.Queue[tuple[_Film, dict[str, Any]]],
    ) -> None:
        self.job: Job | None = None
        self._told = told
        self._complaints = tempfile.TemporaryFile()  # noqa: SIM115
        words = [str(work), str(speaker.folder / "head.npz"), *labels]
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "abs_engine.studio.film_process", *words],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._complaints,
            env=_environment(),
            text=True,
        )
        self._jobs: Any = self._process.stdin
        self._said: Any = self._process.stdout
        self._reader = threading.Thread(target=self._listen, daemon=True)
        self._reader.start()

    def start(self, job: Job) -> None:
        """Film a chunk; a process that has ended says so through `told`."""
        self.job = job
        try:
            self._jobs.write(json.dumps(vars(job)) + "\n")
            self._jobs.flush()
        except OSError:
            return

    def _listen(self) -> None:
        for line in self._said:
            self._told.put((self, json.loads(line)))
        last = last_words(self._process, self._complaints)
        self._told.put(
            (self, {"error": ["StudioError", f"a film process ended ({last})", _REMEDY]})
        )

    def __enter__(self) -> _Film:
        return self

    def __exit__(self, *_: object) -> None:
        if self.job is not None:  # in the middle of something
            self._process.kill()
        with suppress(BrokenPipeError):  # a job was still in the buffer
            self._jobs.close()
        self._reader.join()
        self._said.close()
        self._process.wait()
        self._complaints.close()


def _environment() -> dict[str, str]:
    """Environment of a film process: this package, and one core's worth of threads."""
    root = str(Path(__file__).resolve().parents[2])
    paths = [root, *filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))]
    threads = {"OPENBLAS_NUM_THREADS": "1", "LP_NUM_THREADS": "0"}
    return {**threads, **os.environ, "PYTHONPATH": os.pathsep.join(paths)}
