"""Many pictures: one frame of them, a film of all, or a sheet of evenly spread ones."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from abs_engine.core.arrays import Image
from abs_engine.core.errors import ParameterError
from abs_engine.core.kinds import checked_frame
from abs_engine.report.drawing.layout import columns_of, evenly, sheet
from abs_engine.report.inspect.output import Progress
from abs_engine.report.inspect.request import Request

SHEET_TILES = 20
"""Frames on a sheet."""


@dataclass(frozen=True, eq=False)
class Film:
    """Frames to be written as a video.

    Parameters
    ----------
    frames : iterable of (H, W, 3) uint8 RGB
    count : int
    rate : float
        Frames per second.
    """

    frames: Iterable[Image]
    count: int
    rate: float


def presented(
    request: Request,
    film: bool,
    count: int,
    rate: float,
    painted: Callable[[list[int]], Iterator[Image]],
    progress: Progress | None,
) -> Image | Film:
    """Requested pictures: one frame, a film of all frames, or a sheet of evenly spread ones.

    Parameters
    ----------
    request : Request
    film : bool
    count : int
        How many frames there are.
    rate : float
        Frames per second.
    painted : callable
        Given numbers of frames, yields their pictures, all of one size.
    progress : callable, optional

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
        return Film(painted(list(range(count))), count, rate)
    wanted, tiles = evenly(count, SHEET_TILES), []
    for tile in painted(wanted):
        tiles.append(tile)
        if progress is not None:
            progress(len(tiles), len(wanted))
    if len(tiles) == 1:
        return tiles[0]
    return sheet(tiles, columns_of(len(tiles), (tiles[0].shape[1], tiles[0].shape[0])))
