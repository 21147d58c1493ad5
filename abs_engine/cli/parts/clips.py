"""``abs-engine track`` of many clips: a task each for the workers of a scheduler."""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from abs_engine.cli.parts.command import Chosen, Command, Done
from abs_engine.cli.parts.drawing import opened, print_hints
from abs_engine.cli.parts.progress import Progress
from abs_engine.cli.parts.settings import SETTINGS, settings_text
from abs_engine.core.clock import write_timing
from abs_engine.core.errors import ParameterError
from abs_engine.core.words import counted

if TYPE_CHECKING:
    from abs_engine.clips.job import Job, Outcome
    from abs_engine.tracking.options import TrackOptions

_NAMED = 20  # clips with lost frames or warnings that are listed


def are_many(chosen: Chosen) -> bool:
    """Whether a folder of runs is asked for, not one run."""
    return len(chosen.videos) > 1 or chosen.workers is not None or chosen.scheduler is not None


def track_clips(command: Command, chosen: Chosen, options: TrackOptions) -> Done:
    """Track each clip into a folder of its own, and write their table."""
    from abs_engine.clips.cluster import local_workers, workers_of
    from abs_engine.clips.job import FAILED, TABLE
    from abs_engine.clips.many import track_many
    from abs_engine.clips.table import Table, rows_of_others, runs_folder, timing_of_others
    from abs_engine.clips.worker import check_same_options
    from abs_engine.tracking.runs.output import SHEET

    if chosen.workers is not None and chosen.scheduler is not None:
        raise ParameterError("a scheduler has workers of its own", "leave out --workers")
    jobs = _jobs(command, chosen, options)
    outcomes: dict[str, Outcome] = {}
    start, deaths = time.perf_counter(), Counter[str]()
    with runs_folder(chosen.output) as folder, Progress("tracking", "clips") as progress:
        for job in jobs:
            check_same_options(job)  # refused while the table is as it was
        others = rows_of_others(folder, jobs)
        if chosen.scheduler is None:
            with opened(chosen.renderer) as renderer:  # what is wrong with it is said once
                print_hints(renderer)
            count = chosen.workers or len(os.sched_getaffinity(0))
            workers = local_workers(min(count, len(jobs)), folder.absolute())
        else:
            workers = workers_of(chosen.scheduler)
        progress.announce("waiting for workers")
        with _said_what_is_kept(folder), workers as client:
            table = Table(folder, jobs, others)
            table.write(outcomes)
            try:
                for job, outcome in track_many(client, jobs, deaths):
                    outcomes[job.name] = outcome
                    table.refresh(outcomes)
                    progress(len(outcomes), len(jobs))
            finally:  # interrupted, too
                table.write(outcomes)
        earlier = timing_of_others(folder, others)
        _write_timing(folder, time.perf_counter() - start, outcomes, deaths, earlier)
    failed = {job.name: outcomes[job.name] for job in jobs if outcomes[job.name].status == FAILED}
    done, path = len(jobs) - len(failed), chosen.output / TABLE
    look = f"; look at each clip's {SHEET}" if done else ""
    lines = [
        *_doubtful({name: outcome for name, outcome in outcomes.items() if name not in failed}),
        *(f"failed: {name}: {outcome.message}" for name, outcome in failed.items()),
        f"{done} of {len(jobs)} clips done; wrote {path}{look}",
    ]
    facts = {
        "output": chosen.output,
        "table": path,
        "done": done,
        "failed": {name: outcome.message for name, outcome in failed.items()},
    }
    return Done(lines, facts, 2 if failed else 0)


def _doubtful(done: Mapping[str, Outcome]) -> Iterator[str]:
    """Lines about clips that lost frames or have warnings, the first of them; the table has all."""
    from abs_engine.clips.job import BETWEEN

    lines = []
    for name, outcome in sorted(done.items()):
        frames, found = outcome.frames or 0, outcome.found or 0
        lost = [f"{frames - found} of {counted(frames, 'frame')} lost"] if found < frames else []
        warnings = outcome.message.split(BETWEEN) if outcome.message else []
        more = f" (and {len(warnings) - 1} more)" if len(warnings) > 1 else ""
        warned = [f"warning: {warnings[0]}{more}"] if warnings else []
        lines += [f"{name}: {'; '.join([*lost, *warned])}"] if lost or warned else []
    yield from lines[:_NAMED]
    if len(lines) > _NAMED:
        more = counted(len(lines) - _NAMED, "more clip")
        yield f"and {more} with lost frames or warnings"


@contextmanager
def _said_what_is_kept(folder: Path) -> Iterator[None]:
    """Let who interrupts it know, once there is something."""
    from abs_engine.clips.job import TABLE

    try:
        yield
    except KeyboardInterrupt:
        if not (folder / TABLE).is_file():
            raise
        raise KeyboardInterrupt(
            f"what was done is kept in {folder}; the same command resumes there"
        ) from None


def _jobs(command: Command, chosen: Chosen, options: TrackOptions) -> list[Job]:
    from abs_engine.clips.job import Job, run_names

    videos = [_plain(video.absolute()) for video in chosen.videos]
    folders = [chosen.output.absolute() / name for name in run_names(videos)]
    plugins = tuple(plugin.absolute() for plugin in chosen.plugin)
    options = _absolute(options)
    return [
        Job(video, folder, chosen.renderer, options, plugins,
            {SETTINGS: settings_text(command, vars(chosen), folder)})
        for video, folder in zip(videos, folders, strict=True)
    ]  # fmt: skip


def _plain(video: Path) -> Path:
    """The same without "..", so that its folder has a name."""
    return video.parent.resolve() / video.name if ".." in video.parts else video


def _absolute(options: TrackOptions) -> TrackOptions:
    """The same, wherever a worker was started."""
    paths: dict[str, Any] = {
        name: path.absolute() for name, path in vars(options).items() if isinstance(path, Path)
    }
    if options.model is not None and Path(options.model).is_file():
        paths["model"] = str(Path(options.model).absolute())
    return replace(options, **paths)


def _write_timing(
    folder: Path,
    seconds: float,
    outcomes: Mapping[str, Outcome],
    deaths: Mapping[str, int],
    earlier: Mapping[str, Mapping[str, Any]],
) -> None:
    each = {name: round(outcome.seconds, 2) for name, outcome in outcomes.items()}
    clips = dict(sorted({**earlier["clips"], **each}.items()))
    died = dict(sorted({**earlier["workers_died"], **deaths}.items()))
    write_timing(folder, {"seconds": round(seconds, 2), "workers_died": died, "clips": clips})
