"""Sources of live frames: a camera, a file played at its own speed, or a URL."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from concurrent.futures import Future
from itertools import chain
from pathlib import Path
from typing import Protocol

import cv2
import numpy as np

from abs_engine.core.arrays import Image
from abs_engine.core.errors import ParameterError, VideoError
from abs_engine.io.video import probe, read_frames
from abs_engine.io.video.stream import Stream

_USUAL_RATE, _MOST_RATE = 25.0, 240.0  # of a source that does not say; one that says more is wrong


class Feed(Protocol):
    """A source of frames in real time.

    Attributes
    ----------
    name : str
    size : tuple of int
        Width and height, px.
    rate : float
        Frames per second, as far as it is known.
    lost : bool
        Whether frames that stop coming are a fault.
    """

    name: str
    size: tuple[int, int]
    rate: float
    lost: bool

    def frames(self) -> Iterator[tuple[Image, float]]:
        """Each frame (H, W, 3) uint8 RGB, and when it was taken by `time.monotonic`."""
        ...


class FileFeed:
    """A video file, played at its own speed.

    Parameters
    ----------
    repeat : int
        How often it is played.

    Raises
    ------
    InputFileError, VideoError
        If it cannot be read.
    """

    lost = False

    def __init__(self, path: Path, repeat: int = 1) -> None:
        info = probe(path)
        self.name, self.size, self.rate = path.name, info.size, info.rate
        self._path, self._repeat = path, repeat
        self._times = info.times or tuple(k / info.rate for k in range(info.frames))

    def frames(self) -> Iterator[tuple[Image, float]]:
        """Each frame, and when it is shown."""
        start = time.monotonic()
        for _ in range(self._repeat):
            for image, after in zip(read_frames(self._path), self._times, strict=False):
                yield image, _waited(start + after)
            start += self._times[-1] + 1 / self.rate


class UrlFeed:
    """A URL, by FFmpeg; a video of a known length is played at its own speed, others are live.

    Raises
    ------
    VideoError
        If it cannot be opened, or shows nothing.
    """

    def __init__(self, url: str) -> None:
        stream = Stream(url)
        self.name, self.lost, self.rate = url, not stream.recorded, _likely(stream.rate)
        self._frames = stream.frames()
        first = next(self._frames, None)
        if first is None:
            raise VideoError(f"{url} shows nothing", "check what sends it")
        self._first, self.size = first, _size(first[0])

    def frames(self) -> Iterator[tuple[Image, float]]:
        """Each frame, and when it came or, of a known length, is shown."""
        start, begins = time.monotonic(), self._first[1] or 0.0
        for count, (image, at) in enumerate(chain([self._first], self._frames)):
            _check_size(self, image)
            after = count / self.rate if at is None else at - begins
            yield image, time.monotonic() if self.lost else _waited(start + after)


class CameraFeed:
    """A camera, by OpenCV.

    Parameters
    ----------
    source : str
        Its number or device.

    Raises
    ------
    VideoError
        If it cannot be opened, or shows nothing.
    """

    lost = True

    def __init__(self, source: str) -> None:
        number = int(source) if source.isdecimal() else None
        self.name = source if number is None else f"camera {source}"
        self._capture = _opened(self.name, source if number is None else number)
        there, image = self._capture.read()
        if not there:
            raise VideoError(f"{self.name} shows nothing", _REMEDY)
        self._first: Image = np.asarray(image, np.uint8)
        self.size = _size(self._first)
        self.rate = _likely(self._capture.get(cv2.CAP_PROP_FPS))

    def frames(self) -> Iterator[tuple[Image, float]]:
        """Each frame, and when it came."""
        there, image = True, self._first
        try:
            while there:
                _check_size(self, image)
                yield np.ascontiguousarray(image[..., ::-1]), time.monotonic()
                there, read = self._capture.read()
                image = np.asarray(read, np.uint8) if there else image
        finally:
            self._capture.release()


def _size(image: Image) -> tuple[int, int]:
    return image.shape[1], image.shape[0]


def _check_size(feed: Feed, image: Image) -> None:
    if _size(image) != feed.size:
        raise VideoError(f"{feed.name} has changed its size", "start again")


def _likely(rate: float) -> float:
    return rate if 1 <= rate <= _MOST_RATE else _USUAL_RATE


_REMEDY = "check that it is connected and not in use, or give a file or a URL"


def _opened(name: str, source: str | int) -> cv2.VideoCapture:
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)  # what fails is said here
    try:
        capture = cv2.VideoCapture(source)
    except cv2.error as error:  # a number that no camera has
        raise VideoError(f"{name} cannot be opened", _REMEDY) from error
    if not capture.isOpened():
        raise VideoError(f"{name} cannot be opened", _REMEDY)
    capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)  # old frames are of no use
    return capture


def _waited(until: float) -> float:
    """The same time, once it has come."""
    left = until - time.monotonic()
    if left > 0:
        time.sleep(left)
    return until


def _url_feed(url: str) -> UrlFeed:
    """The feed of a URL, opened by a thread, as Ctrl-C does not end FFmpeg while it waits."""
    made: Future[UrlFeed] = Future()

    def run() -> None:
        try:
            made.set_result(UrlFeed(url))
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
        return _url_feed(source) if "://" in source else CameraFeed(source)
    return FileFeed(Path(source), repeat)
