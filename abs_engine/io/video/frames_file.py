"""Frames that are in memory, or made one after another, as a file that can be tracked."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from os import PathLike

import numpy as np
from numpy.typing import ArrayLike, NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.kinds import to_path
from abs_engine.io.files import check_free, write_new
from abs_engine.io.pictures import MOST_PIXELS
from abs_engine.io.video.writer import Frame, film_bytes

_RATES = 1e-3, 1e4  # Hz; an MP4 would hold other times where frames are closer or further apart
_WIDEST = 1 << 14  # px, of x264


def write_video(
    path: str | PathLike[str],
    frames: Iterable[NDArray[np.uint8]],
    rate: float,
    times: ArrayLike | None = None,
) -> None:
    """Write frames as a video, without loss: what is read from it are the same pixels.

    Parameters
    ----------
    path : path
        A new file, ``.mp4`` (H.264).
    frames : iterable of (H, W, 3) uint8
        RGB, row 0 at the top, all of one size. They are taken one by one.
    rate : float
        Frames per second.
    times : (T,) float64, optional
        When each frame is shown, s, increasing; by default they are evenly spaced. The first frame
        is shown at 0, whatever its time.

    Raises
    ------
    ParameterError
        If there is no frame, one is of another kind or size, or rate or times are unusable.
    OutputError
        If the file exists, has another ending, or cannot be written.

    Examples
    --------
    >>> abs_engine.write_video("talk.mp4", frames, rate=25)  # doctest: +SKIP
    >>> run = abs_engine.track("talk.mp4")  # doctest: +SKIP
    """
    place = check_free(to_path("path", path), ".mp4")
    if not isinstance(rate, (int, float, np.number)) or not _RATES[0] <= rate <= _RATES[1]:
        raise ParameterError(f"the rate is {rate!r}", "give frames per second, such as 25")
    shown = None if times is None else _seconds(times)
    count = None if shown is None else len(shown)
    write_new(place, film_bytes(_checked(frames, count), float(rate), 0, shown))


def _seconds(times: ArrayLike) -> FloatArray:
    """The times (T,) as numbers; else `ParameterError`."""
    remedy = "give seconds, one for each frame"
    try:
        shown = np.asarray(times, np.float64)
    except (TypeError, ValueError) as error:
        raise ParameterError("the times are not numbers", remedy) from error
    gaps = np.diff(shown) if shown.ndim == 1 else np.zeros(1)
    if not (gaps > 0).all():
        raise ParameterError("the times do not increase", remedy)
    for gap in (gaps.min(initial=1), gaps.max(initial=1)):
        if not _RATES[0] <= 1 / gap <= _RATES[1]:
            raise ParameterError(f"two frames are {gap:g} s apart", remedy)
    return shown


def _checked(frames: Iterable[NDArray[np.uint8]], count: int | None) -> Iterator[Frame]:
    """The frames, each as it can be written; as many as there are times, `count`, if any."""
    first, number = None, 0
    for number, frame in enumerate(frames, 1):
        shape, kind = np.shape(frame), getattr(frame, "dtype", type(frame).__name__)
        if kind != np.uint8 or len(shape) != 3 or shape[2] != 3 or not np.size(frame):
            raise ParameterError(
                f"frame {number - 1} is {kind} of the shape {shape}",
                "give uint8 RGB of the shape (height, width, 3)",
            )
        if max(shape) > _WIDEST or shape[0] * shape[1] > MOST_PIXELS:
            raise ParameterError(
                f"frame {number - 1} is {shape[1]} x {shape[0]}, more than a video can be",
                "make the frames smaller, or cut the face out",
            )
        first = first or shape
        if shape != first:
            raise ParameterError(
                f"frame {number - 1} is {shape[1]} x {shape[0]}, the first {first[1]} x {first[0]}",
                "give frames of one size",
            )
        if count is not None and number > count:
            break
        yield frame
    if first is None:
        raise ParameterError("there are no frames", "give at least one")
    if count not in (None, number):
        raise ParameterError(
            f"{count} times were given for another number of frames", "give one for each frame"
        )
