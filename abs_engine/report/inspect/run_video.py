"""Finds the video of a run, which keeps its name, its checksum, and where it was."""

from __future__ import annotations

import logging
from pathlib import Path

from abs_engine.core.errors import InputFileError, ParameterError
from abs_engine.dataset.sums import digest
from abs_engine.evaluate.same_clip import video_sum
from abs_engine.io.video import probe
from abs_engine.report.inspect.runs import RunHead
from abs_engine.tracking.runs.record import SUMMARY, run_settings

_log = logging.getLogger(__name__)
_TRACKED = "give the tracked video with --video"


def find_video(run: RunHead, given: Path | None, beside: Path | None = None) -> Path:
    """The video of a run: what is given, or the file that the run names, where it may lie.

    That is: where the run says that it was; as it is named, from here; in the folder of the run,
    the one above, and ``clip`` in that; and beside the truth. Of several, the one whose checksum
    the run keeps.

    Parameters
    ----------
    given : Path, optional
        The video itself.
    beside : Path, optional
        The video of the truth, of any name.

    Raises
    ------
    InputFileError
        If it is in no such place.
    VideoError
        If it is no video.
    ParameterError
        If its pictures differ from the run's in size or number.
    """
    if given is None:
        video = _found(run.folder, beside)
        _check_size(video, probe(video).size, run.camera.size)
        return video
    check_video(given, run.camera.size, len(run), video_sum(run.folder))
    return given


def check_video(video: Path, size: tuple[int, int], frames: int, wanted: str | None) -> None:
    """Refuse a video that cannot be the one that was tracked; warn of a copy with other bytes.

    Parameters
    ----------
    size : tuple of int
        Width and height of the tracked pictures.
    wanted : str, optional
        SHA-256 of the video that was tracked, where that is known.

    Raises
    ------
    VideoError
        If it is no video.
    ParameterError
        If the size or the number of its pictures differs.
    """
    info = probe(video)
    _check_size(video, info.size, size)
    if wanted is not None and digest(video) == wanted:
        return
    if info.frames != frames:
        raise ParameterError(
            f"{video} and the run differ in number of frames: {info.frames} and {frames}",
            _TRACKED,
        )
    if wanted is not None:
        _log.warning("%s is not the file that was tracked: its checksum differs", video)


def _check_size(video: Path, size: tuple[int, int], wanted: tuple[int, int]) -> None:
    if size != wanted:
        raise ParameterError(
            "{} has {}x{} pixels, the run {}x{}".format(video, *size, *wanted), _TRACKED
        )


def _found(folder: Path, beside: Path | None) -> Path:
    named, stored = _named(folder)
    above = folder.resolve().parent
    places = [folder / stored] if stored else []
    places += [named, *(p / named.name for p in (above, above / "clip", folder))]
    places += [beside] if beside is not None else []
    there = [place for place in dict.fromkeys(places) if place.is_file()]
    if not there:
        raise InputFileError(
            f"the video {named.name} is not beside the run {folder}, nor here, nor where it was",
            "give it with --video FILE, or its dataset with --truth DIR",
        )
    wanted = video_sum(folder)
    if wanted is None:
        return there[0]
    same = next((place for place in there if digest(place) == wanted), None)
    if same is None:
        raise InputFileError(
            f"{there[0]} is not the video that was tracked: its checksum is another",
            "give that one with --video FILE",
        )
    return same


def _named(folder: Path) -> tuple[Path, str]:
    """The video as the run names it, and its path from the run; empty in older runs."""
    settings = run_settings(folder)
    name, stored = settings.get("video"), settings.get("video_path")
    if not isinstance(name, str) or not name:
        raise InputFileError(
            f"{folder / SUMMARY} does not name the video", "give it with --video FILE"
        )
    return Path(name), stored if isinstance(stored, str) else ""
