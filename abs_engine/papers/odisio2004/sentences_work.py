"""Filming and tracking sentences, one after the other or in several processes.

What is found goes into files (`result_cache.Kept`) and nowhere else: an interrupted run goes on
with those that are there, and whoever wants results reads them.
"""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Camera
from abs_engine.core.provenance import code_digest
from abs_engine.core.scene import Renderer
from abs_engine.face.talking import LOCALS, TalkingFace
from abs_engine.io.assets import Speaker, load_speaker
from abs_engine.papers.odisio2004.result_cache import Kept, digest
from abs_engine.papers.odisio2004.sentences_filmed import (
    Filmed,
    cut,
    film_plan,
    plan_sentence,
    truth_of,
)
from abs_engine.papers.odisio2004.sequence import Settings, Tracked, track
from abs_engine.render.select import open_renderer
from abs_engine.studio.french import Sentence
from abs_engine.studio.plan import ClipPlan

Tell = Callable[[str], None]

_OF_TEXTURES = Settings(limit=300)
_OF_POINTS = Settings(limit=280, coarse=1e-5, tolerance=1e-3, inertia=1e-5, unusual=2.0)


def settings_of(model: str) -> Settings:
    """Settings of the search with an appearance model; chosen on `french.PRACTICE`."""
    return _OF_POINTS if model in LOCALS else _OF_TEXTURES


@dataclass(frozen=True)
class Job:
    """A sentence and the models that it is tracked with."""

    sentence: Sentence
    models: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Work:
    """All that sentences are filmed and tracked with.

    Parameters
    ----------
    folder : Path
        Gets a file for each sentence and model.
    aside : Path
        Gets the frames of those under way.
    beads : int
        On the face.
    postures : (V, P) float64
        Of the corpus, from which a search may start again.
    renderer : str
        What draws, as it describes itself.
    seed : int
        Of head motion, blinks and noise.
    frames : int, optional
        Of each sentence, from its start; by default all.
    settings : Settings, optional
        How frames are searched with any model; by default each is by `settings_of`.
    """

    folder: Path
    aside: Path
    person: str
    beads: int
    camera: Camera
    face: TalkingFace
    postures: FloatArray
    renderer: str
    seed: int = 0
    frames: int | None = None
    settings: Settings | None = None

    def how(self, model: str) -> Settings:
        """Settings of the search with a model."""
        return self.settings or settings_of(model)

    @cached_property
    def kept(self) -> Kept:
        """Path of stored results, with what they depend on."""
        basis = {
            "person": self.person, "beads": self.beads, "seed": self.seed, "frames": self.frames,
            "renderer": self.renderer, "code": code_digest(),
            "camera": digest(self.camera),
            "face": digest([self.face, self.postures]),
        }  # fmt: skip
        return Kept(self.folder, basis, self.aside)

    def plan(self, speaker: Speaker, sentence: Sentence) -> ClipPlan:
        """A sentence before the camera, as long as it is tracked."""
        plan = plan_sentence(speaker, self.person, sentence, self.camera, self.seed, self.beads)
        return cut(plan, self.frames)

    def truth(self, speaker: Speaker, sentence: Sentence) -> Filmed:
        """Ground truth of a sentence's frames, without pictures."""
        plan = self.plan(speaker, sentence)
        return truth_of(speaker, plan, sentence, self.face.shape.vertices)

    def load(self, sentence: Sentence, model: str) -> Tracked | None:
        """A tracked sentence, if it was kept."""
        return self.kept.load(sentence.name, model, self.how(model))

    def left(self, jobs: Sequence[Job]) -> list[Job]:
        """Jobs that are not stored yet."""
        rest = [
            Job(job.sentence, tuple(m for m in job.models if self.load(job.sentence, m) is None))
            for job in jobs
        ]
        return [job for job in rest if job.models]


@dataclass
class _Clock:
    """Says how far a run is."""

    tell: Tell
    total: int
    done: int = 0
    started: float = field(default_factory=time.monotonic)

    def __call__(self, job: Job, doing: str) -> None:
        past = time.monotonic() - self.started
        ahead = (self.total - self.done) * past / self.done / 60 if self.done else None
        left = "" if ahead is None else f", about {ahead:.0f} min left"
        self.tell(f"{doing} {job.sentence.name}: {self.done} of {self.total} sentences done{left}")


def track_sentences(
    work: Work,
    jobs: Sequence[Job],
    speaker: Speaker,
    renderer: Renderer,
    *,
    workers: int = 1,
    renderer_name: str = "auto",
    tell: Tell = lambda _text: None,
) -> None:
    """Film and track sentences, those that are not kept yet.

    Parameters
    ----------
    speaker, renderer
        Used where there is one process; others read the bundled one, and open `renderer_name`.
    workers : int
        Processes; each films and draws by itself.
    tell : callable
        Called with what is done next, and about how long the rest takes.

    Raises
    ------
    StudioError
        If pyrender cannot draw on this machine.
    OutputError
        If results cannot be written.
    """
    left = work.left(jobs)
    clock = _Clock(tell, len(left))
    if len(left) < len(jobs):
        tell(f"{len(jobs) - len(left)} of {len(jobs)} sentences were there from before")
    if workers <= 1 or len(left) <= 1:
        for job in left:
            clock(job, "filming and tracking")
            for rest in work.left([job]):  # another process may have done it since
                track_job(work, rest, speaker, renderer)
            clock.done += 1
        return
    context = multiprocessing.get_context("spawn")  # an OpenGL context does not survive a fork
    with ProcessPoolExecutor(
        min(workers, len(left)), context, _open, (work, renderer_name)
    ) as pool:
        asked = {pool.submit(_track_apart, job): job for job in left}
        try:
            for found in as_completed(asked):
                found.result()
                clock.done += 1
                clock(asked[found], "tracked")
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def track_job(work: Work, job: Job, speaker: Speaker, renderer: Renderer) -> None:
    """Film a sentence, track it with each model, and keep what was found."""
    shape = work.face.shape
    filmed = film_plan(speaker, work.plan(speaker, job.sentence), job.sentence, shape.vertices)
    for model in job.models:
        how = work.how(model)
        found = track(
            work.face, model, filmed.pictures, filmed.camera, filmed.poses[0], shape.neutral,
            renderer, how, work.postures,
            work.kept.journal(job.sentence.name, model, how),
        )  # fmt: skip
        work.kept.save(job.sentence.name, model, how, found)


_Here = tuple[Work, Speaker, Renderer]
_here: list[_Here] = []
"""In a process of the pool: what all its jobs share. The renderer lives as long as the process."""


def _open(work: Work, renderer_name: str) -> None:
    _here.append((work, load_speaker(), open_renderer(renderer_name)))


def _track_apart(job: Job) -> None:
    work, speaker, renderer = _here[0]
    for rest in work.left([job]):
        track_job(work, rest, speaker, renderer)
