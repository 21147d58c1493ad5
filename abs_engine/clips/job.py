"""A clip among many: what a worker is given, and what came of it."""

from __future__ import annotations

import hashlib
import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from abs_engine.core.clock import TIMING
from abs_engine.core.errors import ParameterError
from abs_engine.io.naming import partial_of
from abs_engine.tracking.options import TrackOptions

DONE, FAILED, WAITING = "done", "failed", "waiting"
TABLE = "clips.csv"
OWN = TABLE, TIMING
"""Files about all clips, in the folder of their runs."""
SCRATCH = ".workers"
"""In the folder of the runs: what workers of a local cluster put away."""
BETWEEN = " | "
"""Separates warnings in a message."""
LONGEST = 200
"""Bytes of a run's name that are kept: file systems take 255, files beside it have longer names."""


@dataclass(frozen=True)
class Job:
    """A clip to track.

    Parameters
    ----------
    video, folder : Path
        Absolute; the run is written to `folder`.
    plugins : tuple of Path
        Files that add models, terms, drivers or renderers; absolute.
    beside : dict of str to str
        More files for the run: their text by their names.
    """

    video: Path
    folder: Path
    renderer: str
    options: TrackOptions
    plugins: tuple[Path, ...]
    beside: dict[str, str]

    @property
    def name(self) -> str:
        """That of its run."""
        return self.folder.name


@dataclass(frozen=True)
class Outcome:
    """Outcome of a clip.

    Parameters
    ----------
    status : str
        `DONE`, `FAILED` or `WAITING`.
    message : str
        Why it failed, and what to do; the warnings of one that is done.
    frames, found, closed : int or None
        Numbers of frames: all, those in which the face was found, those with closed lips.
    seconds : float
        That it took; 0 where it was there before.
    """

    status: str
    message: str = ""
    frames: int | None = None
    found: int | None = None
    closed: int | None = None
    seconds: float = 0.0


def run_names(videos: Sequence[Path]) -> list[str]:
    """A name for each clip's run: that of its file, with its folder's before it if it is not alone.

    A long one is cut and ends in digits of a digest of it.

    Raises
    ------
    ParameterError
        If one is given twice, two are named alike even so, or one as something else in the folder
        of all runs.
    """
    twice = next((video for video, count in Counter(videos).items() if count > 1), None)
    if twice is not None:
        raise ParameterError(f"{twice} is given twice", "give it once")
    stems = Counter(video.stem for video in videos)
    names = [_cut(v.stem if stems[v.stem] == 1 else f"{v.parent.name}-{v.stem}") for v in videos]
    taken = {*OWN, SCRATCH, *map(traceback_of, names)}
    taken |= {partial_of(Path(name)).name for name in (*names, *OWN)}
    times = Counter(names)
    for name, video in zip(names, videos, strict=True):
        if name in taken:
            raise ParameterError(
                f"the run of {video} would be named '{name}', which something else there is called",
                "rename the video",
            )
        if times[name] > 1:
            others = (v for n, v in zip(names, videos, strict=True) if n == name and v != video)
            raise ParameterError(
                f"{video} and {next(others)} would both be tracked to '{name}'",
                "rename one, or track them to different folders",
            )
    return names


def traceback_of(name: str) -> str:
    """Name of the file beside a run in which the traceback of an error is kept."""
    return f"{name}.traceback.txt"


def _cut(name: str) -> str:
    """A name that a folder may have, and files beside it that are named after it."""
    whole = os.fsencode(name)
    if len(whole) <= LONGEST:
        return name
    return f"{whole[:LONGEST].decode(errors='ignore')}-{hashlib.sha256(whole).hexdigest()[:8]}"
