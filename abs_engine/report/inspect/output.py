"""Writes a picture or a film, whole or not at all."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from abs_engine.core.arrays import Image
from abs_engine.core.errors import ParameterError
from abs_engine.io.files import png, scratch, write_new
from abs_engine.io.video import VideoWriter

Progress = Callable[[int, int], None]
"""Called with the number of pictures done and of all."""

SUFFIXES = (".png", ".mp4")


def is_film(path: Path) -> bool:
    """Whether a file name asks for a film.

    Raises
    ------
    ParameterError
        If it ends in neither ``.png`` nor ``.mp4``.
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise ParameterError(
            f"{path.name} is neither PNG nor MP4", "let its name end in .png or .mp4"
        )
    return suffix == ".mp4"


def write_picture(path: Path, picture: Image) -> None:
    """Write a new PNG."""
    write_new(path, png(picture))


def write_film(path: Path, frames: Iterable[Image], rate: float) -> int:
    """Write a new MP4, all frames of one size; odd sizes get a white line.

    Returns
    -------
    int
        The number of frames.

    Raises
    ------
    OutputError
        If the file exists or cannot be written.
    """
    count, writer = 0, None
    with scratch() as folder:
        made = folder / "film.mp4"
        try:
            for frame in frames:
                even = _even(frame)
                if writer is None:
                    writer = VideoWriter(made, (even.shape[1], even.shape[0]), rate)
                writer.write(even)
                count += 1
        finally:
            if writer is not None:
                writer.close()
        write_new(path, made.read_bytes())
    return count


def _even(frame: Image) -> Image:
    odd = [(0, n % 2) for n in frame.shape[:2]]
    return np.pad(frame, (*odd, (0, 0)), constant_values=255)
