"""Pictures where a video is expected: sequences of them are not read."""

from __future__ import annotations

import re
from pathlib import Path

_ENDINGS = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp")
_NUMBERED = re.compile(r"%\d*d")  # as FFmpeg names the files of a sequence


def is_still(path: Path) -> bool:
    """Whether a file is named as a picture."""
    return path.suffix.lower() in _ENDINGS


def sequence_of(path: Path) -> str:
    """FFmpeg's options that read a sequence of pictures at a path; empty where it names none.

    Parameters
    ----------
    path : Path
        Of a folder with pictures, or a pattern such as ``%04d.png`` of their names.
    """
    if _NUMBERED.search(path.name) and is_still(path):
        return f"-i '{path}'"
    if not path.is_dir():
        return ""
    first = min((held for held in path.iterdir() if is_still(held)), default=None)
    return "" if first is None else f"-pattern_type glob -i '{path / '*'}{first.suffix}'"


def as_video(sequence: str) -> str:
    """Command that makes a video of a sequence of pictures, given FFmpeg's options that read it."""
    return f"make a video of them: ffmpeg -framerate RATE {sequence} -crf 16 OUT.mp4"
