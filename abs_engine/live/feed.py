"""Sources of live frames: a camera, a file played at its own speed, or a URL."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import cv2
import numpy as np

from abs_engine.core.arrays import Image
from abs_engine.core.errors import ParameterError, VideoError
from abs_engine.io.video import probe, read_frames
from abs_engine.io.video.stream import open_stream

_USUAL_RATE, _MOST_RATE = 25.0, 240.0  # of a source that does not say; one that says more is wrong


@dataclass(frozen=True, eq=False)
class Feed:
    """A source of frames in real time.

    Parameters
    ----------
    size : tuple of int
        Width and height, px.
    rate : float
        Frames per second, as far as it is known.
    lost : bool
        Whether frames that stop coming are a fault.
    frames : callable
        Yields each frame (H, W, 3) uint8 RGB, and when it was taken by `time.monotonic`.
    """

    name: str
    size: tuple[int, int]
    rate: float
    lost: bool
    frames: Callable[[], Iterator[tuple[Image, float]]]


def file_feed(path: Path, repeat: int = 1) -> Feed:
    """A video file, played at its own speed, as often as asked; raises as `probe`."""
    info = probe(path)
    times = info.times or tuple(k / info.rate for k in range(info.frames))

    def frames() -> Iterator[tuple[Image, float]]:
        start = time.monotonic()
        for _ in range(repeat):
            for image, after in zip(read_frames(path), times, strict=False):
                yield image, _waited(start + after)
            start += times[-1] + 1 / info.rate

    return Feed(path.name, info.size, info.rate, False, frames)


def url_feed(url: str) -> Feed:
    """A URL, by FFmpeg; a video of a known length is played at its own speed, others are live.

    Raises
    ------
    VideoError
        If it cannot be opened, or shows nothing.
    """
    stated, recorded, shown = open_stream(url)
    rate = _likely(stated)
    first = next(shown, None)
    if first is None:
        raise VideoError(f"{url} shows nothing", "check what sends it")
    begins = first[1] or 0.0

    def frames() -> Iterator[tuple[Image, float]]:
        start = time.monotonic()
        for count, (image, at) in enumerate(chain([first], shown)):
            after = count / rate if at is None else at - begins
            yield image, _waited(start + after) if recorded else time.monotonic()

    return Feed(url, size_of(first[0]), rate, not recorded, frames)


def camera_feed(source: str) -> Feed:
    """A camera, its number or device, by OpenCV.

    Raises
    ------
    VideoError
        If it cannot be opened, or shows nothing.
    """
    number = int(source) if source.isdecimal() else None
    name = source if number is None else f"camera {source}"
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)  # what fails is said here
    try:
        capture = cv2.VideoCapture(source if number is None else number)
    except cv2.error as error:  # a number that no camera has
        raise VideoError(f"{name} cannot be opened", _REMEDY) from error
    if not capture.isOpened():
        raise VideoError(f"{name} cannot be opened", _REMEDY)
    capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)  # old frames are of no use
    seen, first = capture.read()
    if not seen:
        raise VideoError(f"{name} shows nothing", _REMEDY)

    def frames() -> Iterator[tuple[Image, float]]:
        there, image = True, first
        try:
            while there:
                yield np.ascontiguousarray(image[..., ::-1], np.uint8), time.monotonic()
                there, image = capture.read()
        finally:
            capture.release()

    size = size_of(np.asarray(first, np.uint8))
    return Feed(name, size, _likely(capture.get(cv2.CAP_PROP_FPS)), True, frames)


_REMEDY = "check that it is connected and not in use, or give a file or a URL"


def size_of(image: Image) -> tuple[int, int]:
    """Width and height of a picture, px."""
    return image.shape[1], image.shape[0]


def _likely(rate: float) -> float:
    return rate if 1 <= rate <= _MOST_RATE else _USUAL_RATE


def _waited(until: float) -> float:
    """The same time, once it has come."""
    left = until - time.monotonic()
    if left > 0:
        time.sleep(left)
    return until


def _opened(url: str) -> Feed:
    """The feed of a URL, opened by a thread, as Ctrl-C does not end FFmpeg while it waits."""
    made: Future[Feed] = Future()

    def run() -> None:
        try:
            made.set_result(url_feed(url))
        except BaseException as error:  # noqa: BLE001 - raised again below
            made.set_exception(error)

    threading.Thread(target=run, name="opening", daemon=True).start()
    return made.result()


def is_file(source: str) -> bool:
    """Whether a source is a file: neither a camera by its number or device nor a URL."""
    return not (source.isdecimal() or source.startswith("/dev/") or "://" in source)


def open_feed(source: str, repeat: int = 1) -> Feed:
    """A camera by its number or device, a URL, or else a file, which can be repeated.

    Raises
    ------
    ParameterError
        If something else is to be repeated.
    InputFileError, VideoError
        If it cannot be read.
    """
    if not is_file(source):
        if repeat != 1:
            raise ParameterError("--repeat is for files", "leave it out, or give a file")
        return _opened(source) if "://" in source else camera_feed(source)
    return file_feed(Path(source), repeat)
