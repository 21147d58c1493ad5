"""Many clips, a task each; a clip whose worker dies is tried again as long as it gets on.

One at which several workers in a row die waits for the others. Then it has the machine to itself,
where memory and time may suffice, and is tried some more times before it is given up.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from abs_engine.clips.cluster import replace_lost
from abs_engine.clips.job import FAILED, Job, Outcome
from abs_engine.clips.worker import track_job
from abs_engine.core.errors import ParameterError
from abs_engine.core.foreign import named
from abs_engine.io.naming import partial_of
from abs_engine.tracking.results.frame_journal import FRAMES

if TYPE_CHECKING:
    from distributed import Client, Future

DEATHS = 4
"""Workers that may die in a row at a clip, without a new frame of it, before it is set aside."""
GIVEN_UP = 20
"""The same before it is given up: machines that others stop again and again must lose no clip."""
_LOOK = 2.0  # seconds between looks for workers that came or went


def track_many(
    client: Client, jobs: Sequence[Job], deaths: Counter[str]
) -> Iterator[tuple[Job, Outcome]]:
    """Track clips, as many at once as there are workers; yields each as it ends.

    Parameters
    ----------
    jobs : sequence of Job
        Their names differ.
    deaths : Counter
        Counts the workers that died at each clip, by its name.

    Raises
    ------
    ParameterError
        If the scheduler is gone.
    """
    from distributed import CancelledError

    try:
        yield from _tracked(client, jobs, deaths)
    except (CancelledError, OSError) as error:
        raise _gone() from error


def _tracked(
    client: Client, jobs: Sequence[Job], deaths: Counter[str]
) -> Iterator[tuple[Job, Outcome]]:
    from distributed import wait

    watched = {job.name: _Watched(job) for job in jobs}
    waiting, aside = deque(jobs), deque[Job]()
    running: dict[Future[Outcome], Job] = {}
    while waiting or aside or running:
        replace_lost(client)
        if not waiting and not running:
            waiting.append(aside.popleft())  # by itself
        while waiting and len(running) < max(1, len(client.nthreads())):
            job = waiting.popleft()
            key = f"{job.name!a}-{deaths[job.name]}-{id(client):x}"
            running[client.submit(track_job, job, key=key, pure=False)] = job
        try:
            ended = wait(list(running), timeout=_LOOK, return_when="FIRST_COMPLETED").done
        except TimeoutError:
            continue
        for future in ended:
            job = running.pop(future)
            outcome = _outcome(future, watched[job.name], deaths)
            future.release()
            if outcome is not None:
                yield job, outcome
            elif watched[job.name].deaths >= DEATHS:
                aside.append(job)
            else:
                waiting.appendleft(job)


class _Watched:
    """A clip that may kill its workers; `deaths` are those since its last new frame."""

    def __init__(self, job: Job) -> None:
        self.job = job
        self._journal = partial_of(job.folder) / FRAMES
        self._kept, self.deaths = self._size(), 0

    def _size(self) -> int:
        """Bytes of the frames that are kept."""
        try:
            return self._journal.stat().st_size
        except OSError:  # there is none
            return 0

    def died(self, deaths: int) -> None:
        """Count workers that died at it now."""
        kept = self._size()
        self.deaths = 0 if kept > self._kept else self.deaths + deaths
        self._kept = kept


def _gone() -> ParameterError:
    return ParameterError("the scheduler is gone", "start one; the same command resumes")


def _outcome(future: Future[Outcome], watched: _Watched, deaths: Counter[str]) -> Outcome | None:
    """Outcome of a task; None if it is to be tried again."""
    from distributed import KilledWorker

    if future.status == "finished":
        outcome: Outcome = future.result()
        return outcome
    if future.status != "error":  # cancelled, or lost
        raise _gone()
    error = future.exception()
    if not isinstance(error, KilledWorker):
        return Outcome(FAILED, named(error))
    died = error.allowed_failures + 1
    deaths[watched.job.name] += died
    watched.died(died)
    if watched.deaths < GIVEN_UP:
        return None
    return Outcome(
        FAILED,
        f"its worker died {GIVEN_UP} times without a new frame, at last with no other clip "
        "beside it, perhaps for want of memory; give workers more, then give the same command "
        "again",
    )
