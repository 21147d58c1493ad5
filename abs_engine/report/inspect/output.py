"""Pictures and films: one frame, a sheet or all of them, written whole or not at all."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from abs_engine.core.arrays import FloatArray, Image, evenly
from abs_engine.core.errors import ParameterError
from abs_engine.core.kinds import checked_frame
from abs_engine.report.drawing.layout import columns_of, sheet
from abs_engine.report.inspect.request import Request

Thing = TypeVar("Thing")
Progress = Callable[[int, int], None]
"""Called with the number of pictures done and of all."""

SUFFIXES = (".png", ".mp4")
SHEET_TILES = 20
"""Frames on a sheet."""


@dataclass(frozen=True, eq=False)
class Film:
    """Frames to be written as a video.

    Parameters
    ----------
    frames : iterable of (H, W, 3) uint8 RGB
    rate : float
        Frames per second.
    times : (T,) float64 or None
        When each is shown, s, where that is not at even steps.
    """

    frames: Iterable[Image]
    count: int
    rate: float
    times: FloatArray | None = None


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


def presented(
    request: Request,
    film: bool,
    count: int,
    rate: float,
    painted: Callable[[list[int]], Iterator[Image]],
    progress: Progress | None,
    times: FloatArray | None = None,
) -> Image | Film:
    """Requested pictures: one frame, a film of all frames, or a sheet of evenly spread ones.

    Parameters
    ----------
    painted : callable
        Given numbers of frames, yields their pictures, all of one size.
    times : (T,) float64, optional
        When each frame is shown, s, where that is not at even steps.

    Raises
    ------
    ParameterError
        If there is no such frame.
    """
    if request.frame is not None:
        if film:
            raise ParameterError("one frame is not a film", "let the file's name end in .png")
        return next(painted([checked_frame(request.frame, count)]))
    if film:
        return Film(painted(list(range(count))), count, rate, times)
    wanted = evenly(count, SHEET_TILES)
    tiles = list(reported(painted(wanted), len(wanted), progress))
    if len(tiles) == 1:
        return tiles[0]
    return sheet(tiles, columns_of(len(tiles), (tiles[0].shape[1], tiles[0].shape[0])))


def reported(things: Iterable[Thing], count: int, progress: Progress | None) -> Iterator[Thing]:
    """Things as they come; each is reported when the next is asked for."""
    for done, thing in enumerate(things, 1):
        yield thing
        if progress is not None:
            progress(done, count)


def even_sided(picture: Image) -> Image:
    """A picture with a white line beside each odd side, which a film would cut."""
    odd = [(0, n % 2) for n in picture.shape[:2]]
    return np.pad(picture, (*odd, (0, 0)), constant_values=255)
