"""A worker's part: one clip is tracked, or found to be done."""

from __future__ import annotations

import threading
import time
import traceback
from pathlib import Path
from typing import Any

from abs_engine.clips.job import BETWEEN, DONE, FAILED, Job, Outcome, traceback_of
from abs_engine.core.errors import (
    AbsEngineError,
    BusyOutputError,
    InputFileError,
    OutputError,
    SameOutputError,
)
from abs_engine.core.foreign import named
from abs_engine.core.registry import PLUGINS, load_plugin
from abs_engine.core.release import engine_version
from abs_engine.core.threads import keep_to_one_core
from abs_engine.render.select import opened_renderer
from abs_engine.tracking.run import options_in, track_video
from abs_engine.tracking.runs.output import read_facts

_ONE = threading.Lock()
"""A process tracks one clip at a time, however many threads its scheduler gave it."""
_PATIENCE = 1.0  # seconds between looks at a clip that another process works at


def track_job(job: Job) -> Outcome:
    """Track a clip, or go on where another worker was killed; what is there is kept.

    An error that nobody foresaw leaves its traceback beside the clip's run.
    """
    with _ONE:
        keep_to_one_core()
        try:
            _traceback_of(job).unlink(missing_ok=True)  # of an earlier try
            summary, seconds = _tracked(job)
        except AbsEngineError as error:
            return Outcome(FAILED, " ".join(str(error).split()))
        except Exception as error:  # noqa: BLE001 - it is kept whole, and the other clips go on
            return Outcome(FAILED, _kept(job, error))
    return Outcome(
        DONE,
        " ".join(BETWEEN.join(summary.get("warnings", ())).split()),
        summary["frames"],
        summary["frames"] - summary["lost_frames"],
        summary["closed_frames"],
        seconds,
    )


def _traceback_of(job: Job) -> Path:
    return job.folder.with_name(traceback_of(job.name))


def _kept(job: Job, error: Exception) -> str:
    """Message about an error whose traceback is written beside the clip's run."""
    path = _traceback_of(job)
    try:
        path.write_text(
            "".join(traceback.format_exception(error)), encoding="utf-8", errors="backslashreplace"
        )
    except OSError:  # as of a full disk, which may be the error itself
        return named(error)
    return f"{named(error)}; see {path.name} in the folder of runs"


def _tracked(job: Job) -> tuple[dict[str, Any], float]:
    """Summary of a clip's run, and the seconds that it took; 0 of one that was there, whole."""
    PLUGINS.clear()  # those of a clip before; what they added is replaced
    for plugin in job.plugins:
        load_plugin(plugin)
    start = time.perf_counter()
    while True:
        try:
            with opened_renderer(job.renderer) as renderer:
                run = track_video(job.video, job.folder, renderer, job.options, beside=job.beside)
            return run["summary"], time.perf_counter() - start
        except SameOutputError:
            return read_facts(job.folder)["summary"], 0.0
        except BusyOutputError:  # a worker that was given up, or a command before, is still at it
            time.sleep(_PATIENCE)


def check_same_options(job: Job) -> None:
    """Raise `OutputError` if a run that is there is of another release, or of other options.

    So much is seen without its clip; `track_job` sees the rest.
    """
    try:
        release = read_facts(job.folder)["engine_version"]
    except (InputFileError, KeyError):  # there is none, or none that is whole
        release = engine_version()
    if release != engine_version():
        raise OutputError(
            f"{job.folder} was tracked by abs-engine {release}, and this is {engine_version()}",
            "choose another folder for the runs, or use that release",
        )
    there = {name: job.folder / name for name in job.beside if (job.folder / name).is_file()}
    if any(
        options_in(path.read_text("utf-8", "replace")) != options_in(job.beside[name])
        for name, path in there.items()
    ):
        raise OutputError(
            f"{job.folder} was tracked with other options",
            "choose another folder for the runs, or give the same options",
        )
