"""Pictures where a video is expected: sequences of them are not read."""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
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
        Of a folder that holds pictures alone, or a pattern such as ``%04d.png`` of their names.
    """
    if _NUMBERED.search(path.name) and is_still(path):
        return f"-i {shlex.quote(str(path))}"
    held = _shown(path) if path.is_dir() else []
    return all_of(held) if len(held) > 1 and all(map(is_still, held)) else ""


def all_of(pictures: Sequence[Path]) -> str:
    """FFmpeg's options that read all pictures of the first one's kind, in its folder."""
    pattern = pictures[0].with_name(f"*{pictures[0].suffix}")
    return f"-pattern_type glob -i {shlex.quote(str(pattern))}"


def as_video(sequence: str) -> str:
    """Command that makes a video of a sequence of pictures, given FFmpeg's options that read it."""
    return f"make a video of them: ffmpeg -framerate RATE {sequence} -crf 16 OUT.mp4"


def _shown(folder: Path) -> list[Path]:
    """Contents of a folder, but for hidden files, in the order of their names."""
    return sorted(held for held in folder.iterdir() if not held.name.startswith("."))
