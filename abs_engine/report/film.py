"""The video as the page plays it, and pictures of each system's worst frames."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain, islice

import cv2
import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Window
from abs_engine.core.errors import VideoError
from abs_engine.dataset import Truth
from abs_engine.io.video import film_bytes
from abs_engine.report.data import Film, System, TrueClip, WorstFrame
from abs_engine.report.drawing.colours import TRUTH_ON_PICTURES, picture_colour, rgb
from abs_engine.report.drawing.lines import draw_line
from abs_engine.report.quantities import PRIMARY

LARGEST_WIDTH = 640
QUALITY = 26  # x264's; the page is to be small
_ACROSS = 1.7  # widths of the mouth that a worst frame shows
_PICTURE = 480, 330  # px
WORST = 8
"""Pictures of each system's worst frames."""
_APART_SECONDS = 0.12


def filmed(
    pictures: Iterable[Image], truth: Truth, systems: Sequence[System], true: TrueClip, played: int
) -> tuple[Film, list[System]]:
    """The film, and the systems with pictures of their worst frames."""
    apart = max(1, round(_APART_SECONDS * truth.rate))
    worst = [
        worst_frames(_primary(system)[0], WORST, apart) if system.errors else []
        for system in systems
    ]
    wanted = set(chain.from_iterable(worst))
    shown, kept = shorten(pictures, truth.rate, played, wanted)
    drawn = []
    for number, (system, frames) in enumerate(zip(systems, worst, strict=True)):
        colour = picture_colour(number)
        drawn.append(
            replace(
                system, worst=tuple(_worst(system, colour, k, kept[k], truth, true) for k in frames)
            )
        )
    return shown, drawn


def shorten(
    pictures: Iterable[Image],
    rate: float,
    frames: int,
    wanted: Collection[int],
    times: FloatArray | None = None,
) -> tuple[Film, dict[int, Image]]:
    """The first frames of a video as a small film, and the wanted pictures as they are.

    Parameters
    ----------
    pictures : iterable of (H, W, 3) uint8 RGB
    rate : float
        Frames per second.
    frames : int
        Length of the film.
    wanted : collection of int
        Frames, which may lie behind the end of the film.
    times : (T,) float64, s, optional
        When each frame is shown, where that is not at even steps.

    Raises
    ------
    VideoError
        If the video is shorter than the film is to be, or ends before a wanted frame.
    OutputError
        If temporary files cannot be written.
    """
    last = max([frames - 1, *wanted])
    kept: dict[int, Image] = {}
    size, number = (0, 0), -1

    def small() -> Iterator[Image]:
        nonlocal size, number
        for number, picture in enumerate(islice(pictures, last + 1)):
            size = picture.shape[1], picture.shape[0]
            if number in wanted:
                kept[number] = picture
            if number < frames:
                window = Window(0, 0, *size, min(1.0, LARGEST_WIDTH / size[0]))
                yield picture if window.scale == 1 else np.asarray(window.sample(picture), np.uint8)
        if number < last:
            raise VideoError(
                f"the video has {number + 1} frames, the results {last + 1} or more",
                "give the video that was tracked",
            )

    content = film_bytes(small(), rate, QUALITY, times)  # whose first picture gives the size
    return Film(content, size), kept


def mouth_picture(
    picture: Image, loops: Iterable[tuple[FloatArray, str]], mouth: FloatArray
) -> bytes:
    """The mouth, enlarged, with contours, as WebP.

    Parameters
    ----------
    picture : (H, W, 3) uint8 RGB
    loops : iterable of ((N, 2) float64, str)
        Closed contours, px, and their colours as CSS; those with NaN are left out.
    mouth : (M, 2) float64, px
        Points around which the picture is cut.
    """
    low, high = np.nanmin(mouth, axis=0), np.nanmax(mouth, axis=0)
    wide = _ACROSS * max(4.0, float(high[0] - low[0]))
    tall = wide * _PICTURE[1] / _PICTURE[0]
    x, y = ((low + high - [wide, tall] + 1) / 2).tolist()  # of the first pixel's centre
    window = Window(x, y, wide, tall, _PICTURE[0] / wide)
    drawn = np.ascontiguousarray(window.sample(picture), np.uint8)
    for points, colour in loops:
        if np.isfinite(points).all():
            width = 4 if colour == TRUTH_ON_PICTURES else 2
            draw_line(drawn, window.to_drawn(points), True, rgb(colour), width)
    coded = cv2.imencode(".webp", drawn[..., ::-1], [cv2.IMWRITE_WEBP_QUALITY, 84])[1]
    return coded.tobytes()


def worst_frames(errors: FloatArray, count: int, apart: int) -> list[int]:
    """The frames (T,) of the largest errors, at least `apart` frames from each other.

    Frames without an error are left out.
    """
    left = np.where(np.isfinite(errors), errors, -np.inf)
    chosen: list[int] = []
    while len(chosen) < count and np.isfinite(left.max(initial=-np.inf)):
        frame = int(left.argmax())
        chosen.append(frame)
        left[max(0, frame - apart + 1) : frame + apart] = -np.inf
    return chosen


def _worst(
    system: System, colour: str, frame: int, picture: Image, truth: Truth, true: TrueClip
) -> WorstFrame:
    values, unit = _primary(system)
    loops = [(loop[frame], TRUTH_ON_PICTURES) for loop in true.contours.values()]
    loops += [(loop[frame], colour) for loop in system.contours.values()]
    said = f", /{truth.phonemes[frame]}/" if truth.phonemes else ""
    text = f"frame {frame}, {frame / truth.rate:.2f} s{said}: {values[frame]:.2f} {unit}"
    return WorstFrame(frame, mouth_picture(picture, loops, true.contours["outer"][frame]), text)


def _primary(system: System) -> tuple[FloatArray, str]:
    """The errors by which frames are the worst, and their unit."""
    quantity = next((q for q in PRIMARY if q.key in system.errors), None)
    if quantity is None:
        return np.zeros(0), ""
    return system.errors[quantity.key].values, quantity.unit
