"""A worker's part: one clip is tracked, or found to be done."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from typing import Any

from abs_engine.clips.job import DONE, FAILED, Job, Outcome
from abs_engine.core.errors import (
    AbsEngineError,
    BusyOutputError,
    InputFileError,
    OutputError,
    SameOutputError,
)
from abs_engine.core.registry import PLUGINS, load_plugin
from abs_engine.core.threads import keep_to_one_core
from abs_engine.dataset.sums import digest
from abs_engine.io.inputs import parse_json
from abs_engine.io.naming import made_before
from abs_engine.render.select import open_renderer
from abs_engine.tracking.run import track_video

_ONE = threading.Lock()
"""A process tracks one clip at a time, however many threads its scheduler gave it."""
_PATIENCE = 1.0  # seconds between looks at a clip that another process works at


def track_job(job: Job) -> Outcome:
    """Track a clip, or go on where another worker was killed; what is there is kept."""
    with _ONE:
        keep_to_one_core()
        start = time.perf_counter()
        try:
            facts = _tracked(job)
        except AbsEngineError as error:
            return Outcome(FAILED, " ".join(str(error).split()))
        seconds = time.perf_counter() - start
    summary = facts["summary"]
    return Outcome(
        DONE,
        " ".join(" | ".join(summary.get("warnings", ())).split()),
        summary["frames"],
        summary["frames"] - summary["lost_frames"],
        summary["closed_frames"],
        seconds if "timing" in facts else 0.0,
    )


def _tracked(job: Job) -> dict[str, Any]:
    PLUGINS.clear()  # those of a clip before; what they added is replaced
    for plugin in job.plugins:
        load_plugin(plugin)
    while True:
        known = _known(job)
        if known is not None:
            return known
        try:
            with open_renderer(job.renderer) as renderer:
                return track_video(
                    job.video, job.folder, renderer, job.options, beside=job.beside
                )  # fmt: skip
        except (BusyOutputError, SameOutputError):  # a worker that was given up, or a command
            time.sleep(_PATIENCE)  # before, still tracks it, or has just done it


def _known(job: Job) -> dict[str, Any] | None:
    """Content of the ``run.json`` of a run that is there; None if there is none.

    Raises
    ------
    OutputError
        If it is another clip's, or was tracked with other options.
    """
    if not made_before(job.folder):
        return None
    try:
        facts: dict[str, Any] = parse_json(_text(job.folder / "run.json"), gaps=True)
        told = {name: _text(job.folder / name) for name in job.beside}
        same = told == job.beside and facts["settings"]["video_sha256"] == digest(job.video)
    except (OSError, ValueError, LookupError, TypeError):
        same = False
    if not same:
        raise OutputError(
            f"{job.folder} holds something else than this clip, tracked with these options",
            "choose another folder for the runs, or remove that one",
        )
    return facts


def check_same_options(job: Job) -> None:
    """Raise `OutputError` if a run that is there was tracked with other options."""
    if not made_before(job.folder):
        return
    there = {name: job.folder / name for name in job.beside if (job.folder / name).is_file()}
    if any(_text(path) != job.beside[name] for name, path in there.items()):
        raise OutputError(
            f"{job.folder} was tracked with other options",
            "choose another folder for the runs, or give the same options",
        )


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise InputFileError(f"{path} is no text", "remove it") from error
