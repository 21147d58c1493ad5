"""Makes a data set of plans: films what is missing, gathers, encodes, and gives it its name."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from abs_engine.core.clock import Clock
from abs_engine.core.errors import ParameterError
from abs_engine.dataset import ClipEntry
from abs_engine.dataset.codec import CHUNK, SCENE
from abs_engine.io.assets import Speaker
from abs_engine.studio.chunk import Filmer, Job, jobs_of
from abs_engine.studio.finish import clip_entry, finish_clip, finish_dataset
from abs_engine.studio.journal import Journal
from abs_engine.studio.plan import ClipPlan, load, store
from abs_engine.studio.pool import film_apart

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Filmed:
    """A data set that was made.

    Parameters
    ----------
    frames : int
        Pictures, of all clips and cameras.
    resumed : int
        How many of them were there already.
    seconds : dict of str to float
        What was spent on all pictures, by part, each in seconds of one core.
    """

    folder: Path
    frames: int
    resumed: int
    seconds: dict[str, float]


@dataclass(frozen=True)
class Crew:
    """Settings of the film crew: processes and renderer.

    Parameters
    ----------
    processes : int
        How many film at once; 0 is one for each core.
    keep : bool
        Whether finished chunks stay, to go on from, when filming is interrupted or fails.
    announce : callable
        Called with what is done next, such as 'encoding'.
    filming, encoding : callable, optional
        Called with the number of frames done and of all frames; those that were there already do
        not count.
    """

    processes: int = 0
    keep: bool = False
    announce: Callable[[str], None] = lambda _text: None
    filming: Progress | None = None
    encoding: Progress | None = None


@dataclass(frozen=True)
class Order:
    """Name and content of a data set, besides its clips.

    Parameters
    ----------
    labels : tuple of str
        Of normals, albedo and flow.
    keep_frames : bool
        Whether the pictures stay when they are encoded.
    scene : str
        Text of the scene file, or ''.
    digest : str
        Of all that the data set follows from.
    """

    command: str
    seed: int
    labels: tuple[str, ...]
    keep_frames: bool
    scene: str = ""
    digest: str = ""


def make(
    plans: Iterable[ClipPlan], number: int, folder: Path, speaker: Speaker, order: Order, crew: Crew
) -> Filmed:
    """Film plans into a data set.

    Parameters
    ----------
    plans : iterable of ClipPlan
        Only one is in memory at a time.
    number : int
        How many there are.
    folder : Path
        Must not exist; it appears when everything is written.

    Raises
    ------
    ParameterError
        If the mesh has too many facets; what working out a plan raises.
    OutputError
        If the folder exists or cannot be written.
    StudioError
        If pyrender cannot draw on this machine.
    KeyboardInterrupt
        If interrupted; its text says what was kept.
    """
    if len(speaker.faces) > 65_534:
        raise ParameterError(
            f"{len(speaker.faces)} facets do not fit 16-bit ids", "film a head of fewer facets"
        )
    with Journal(folder, order.digest) as journal:
        try:
            clips = _plan(plans, number, journal, crew)
            jobs = jobs_of([(clip.frames, len(clip.cameras)) for clip in clips])
            left = [job for job in jobs if not journal.done(job.name)]
            count = _Count(crew.filming, _frames(left, clips))
            _film(left, journal, speaker, order.labels, crew, count)
            seconds = _finish(jobs, clips, journal, speaker, order, crew)
            made = journal.finish()
        except BaseException:
            if not crew.keep or not any(journal.chunks.glob("[0-9]*.npz")):
                journal.discard()
            raise
    return Filmed(made, _frames(jobs, clips), _frames(jobs, clips) - _frames(left, clips), seconds)


def _plan(plans: Iterable[ClipPlan], number: int, journal: Journal, crew: Crew) -> list[ClipEntry]:
    """Work out all clips, or read what was worked out before; only one is in memory at a time."""
    made = iter(plans)
    clips = []
    known = journal.resumed and journal.plan(number - 1).is_file()
    for clip in range(number):
        crew.announce(f"clip {clip + 1} of {number}: who, what and where")
        if known:
            plan = load(journal.plan(clip))
        else:
            plan = next(made)
            store(plan, journal.plan(clip))
        clips.append(clip_entry(plan))
    return clips


def _frames(jobs: list[Job], clips: list[ClipEntry]) -> int:
    return sum(min(CHUNK, clips[job.clip].frames - job.chunk * CHUNK) for job in jobs)


class _Count:
    """Counts frames and tells."""

    def __init__(self, tell: Progress | None, total: int) -> None:
        self._tell, self._total, self._done = tell, total, 0

    def __call__(self) -> None:
        self._done += 1
        if self._tell is not None:
            self._tell(self._done, self._total)


def _film(
    jobs: list[Job],
    journal: Journal,
    speaker: Speaker,
    labels: tuple[str, ...],
    crew: Crew,
    count: _Count,
) -> None:
    """Film chunks, by several processes or here, one after the other."""
    processes = min(crew.processes or _cores(), len(jobs))
    if processes > 1:
        film_apart(jobs, journal, speaker, labels, count, processes)
    elif jobs:
        with Filmer(journal.partial, speaker, labels) as filmer:
            for job in jobs:
                filmer.film(job, count)


def _cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0))


def _finish(
    jobs: list[Job],
    clips: list[ClipEntry],
    journal: Journal,
    speaker: Speaker,
    order: Order,
    crew: Crew,
) -> dict[str, float]:
    """Gather, encode and sign; returns the seconds spent by part."""
    crew.announce("encoding videos")
    count = _Count(crew.encoding, _frames(jobs, clips))
    clock = Clock()
    with clock.part("video"):
        for number in range(len(clips)):
            finish_clip(
                load(journal.plan(number)),
                [job for job in jobs if job.clip == number],
                journal.chunks,
                journal.work,
                speaker,
                keep_frames=order.keep_frames,
                advance=count,
                clock=clock,
            )
    if order.scene:
        (journal.work / SCENE).write_text(order.scene, encoding="utf-8")
    crew.announce("checksums")
    finish_dataset(
        journal.work, clips, command=order.command, seed=order.seed, labels=order.labels,
        seconds=clock.seconds,
    )  # fmt: skip
    return dict(clock.seconds)
