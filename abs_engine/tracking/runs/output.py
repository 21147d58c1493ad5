"""Writes a run while it is tracked: tables, overlay video and contact sheet."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from abs_engine.core.arrays import Image
from abs_engine.core.clock import TIMING, write_timing
from abs_engine.core.errors import InputFileError
from abs_engine.core.threads import closed_after, meanwhile, one_thread
from abs_engine.io.files import png
from abs_engine.io.inputs import read_json
from abs_engine.tracking.frame.clip_setting import ClipSetting, FrameResult
from abs_engine.tracking.results.overlay import Overlay
from abs_engine.tracking.results.run_pictures import ContactSheet, HeadKeeper
from abs_engine.tracking.results.run_table import LESS
from abs_engine.tracking.runs.record import SUMMARY, Record
from abs_engine.tracking.runs.recorder import Recorder

OVERLAY, SHEET, COLOURS = "overlay.mp4", "contact_sheet.png", "colours.npz"
HEAD = "head.png"

Progress = Callable[[int, int], None]
"""Called with the number of frames done and of all frames (0 where that is not known)."""


def write_run(
    folder: Path,
    setting: ClipSetting,
    results: Iterable[tuple[Image, FrameResult]],
    settings: dict[str, Any],
    expected: int,
    progress: Progress | None = None,
    *,
    kept: Path | None = None,
    preparation: float = 0.0,
    resumed: int = 0,
) -> tuple[Record, dict[str, Any]]:
    """Track to the end and write everything into an existing folder.

    Results are as `track` yields them; `expected` is their number, 0 where that is not known. The
    settings, JSON values, are for ``run.json``. `progress` is called after every frame. The frames'
    numbers are in the folder `kept`, by default the same one, until they are written. `preparation`
    took some seconds, and `resumed` frames had been found before. With the record what ``run.json``
    holds is returned, and `timing`, what ``timing.json`` holds.

    Raises
    ------
    OSError
        If the folder cannot be written.
    """
    recorder = Recorder(setting, kept or folder)
    sheet = ContactSheet(setting)
    head = HeadKeeper(setting, expected)
    start, busy = time.perf_counter(), time.process_time()
    with closed_after(results), Overlay(folder / OVERLAY, setting, sheet.add) as overlay:
        for image, result in results:
            recorder.add(result, image)
            overlay.add(image, result)
            head.add(image, result)
            if progress is not None:
                progress(len(recorder), max(expected, len(recorder)) if expected else 0)
    took, busy = time.perf_counter() - start, time.process_time() - busy
    record, stated = recorder.record(), {"settings": settings}
    with one_thread(), meanwhile(record.write, folder, stated) as written:
        (folder / SHEET).write_bytes(png(sheet.picture(record.arrays[LESS])))
        whole = head.picture()
        if whole is not None:
            (folder / HEAD).write_bytes(png(whole))
    classes = setting.face.appearance.get("colour")
    if classes is not None:
        classes.save(folder / COLOURS)
    spent, frames = setting.clock.seconds, max(1, len(recorder))
    parts = {**spent, "other": max(busy - sum(spent.values()), 0.0)}
    timing = {
        "resumed_frames": resumed,
        "preparation_seconds": round(preparation, 3),
        "seconds_per_frame": round(took / frames, 5),
        "processor_ms_per_frame": {k: round(1e3 * s / frames, 2) for k, s in parts.items()},
    }
    write_timing(folder, timing)
    return record, {**written.result(), "timing": timing}


def read_facts(folder: Path) -> dict[str, Any]:
    """Facts of a run that is there, as `write_run` returned them.

    Raises
    ------
    InputFileError
        If ``run.json`` or ``timing.json`` cannot be read.
    """
    told = []
    for path in (folder / SUMMARY, folder / TIMING):
        try:
            told.append(dict(read_json(path, gaps=True)))
        except (OSError, ValueError, TypeError) as error:
            raise InputFileError(f"{path} cannot be read", "track the clip again") from error
    return {**told[0], "timing": told[1]}
