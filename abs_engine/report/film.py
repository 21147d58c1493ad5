"""The video as the page plays it, and single pictures of it."""

from __future__ import annotations

from collections.abc import Collection, Iterable

import cv2
import numpy as np

from abs_engine.core.arrays import FloatArray, Image
from abs_engine.core.camera import Window
from abs_engine.core.errors import VideoError
from abs_engine.io.files import scratch
from abs_engine.io.video import VideoWriter
from abs_engine.report.data import Film
from abs_engine.report.drawing.colours import TRUTH_ON_PICTURES, rgb
from abs_engine.report.drawing.lines import draw_line

LARGEST_WIDTH = 640
QUALITY = 26  # x264's; the page is to be small
_ACROSS = 1.7  # widths of the mouth that a worst frame shows
_PICTURE = 480, 330  # px


def shorten(
    pictures: Iterable[Image], rate: float, frames: int, wanted: Collection[int]
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
    with scratch() as folder:
        path = folder / "film.mp4"
        writer: VideoWriter | None = None
        try:
            for number, picture in enumerate(pictures):
                size = picture.shape[1], picture.shape[0]
                window = Window(0, 0, *size, min(1.0, LARGEST_WIDTH / size[0]))
                if writer is None:
                    writer = VideoWriter(path, window.drawn, rate, QUALITY)
                if number < frames:
                    writer.write(
                        np.asarray(
                            picture if window.scale == 1 else window.sample(picture), np.uint8
                        )
                    )
                if number in wanted:
                    kept[number] = picture
                if number == last:
                    break
        finally:
            if writer is not None:
                writer.close()
        if number < last:
            raise VideoError(
                f"the video has {number + 1} frames, the results {last + 1} or more",
                "give the video that was tracked",
            )
        return Film(path.read_bytes(), size), kept


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
