"""Pictures as they are shown: upright, and with square pixels."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import av
import cv2
import numpy as np
from av.filter import Graph
from av.sidedata.sidedata import Type
from av.video.reformatter import VideoReformatter
from numpy.typing import NDArray

from abs_engine.io.video.writer import Frame

_SQUARE = 0.01  # pixels that are so nearly square are
_LONGEST = 3.0  # a longer pixel is a mistake in the file
_ASKEW = 0.02  # of a matrix's largest entry: an angle of about a degree
_HARMFUL = (Type.ICC_PROFILE.value, 28, 29, 30, 31)
"""Numbers of what PyAV 18 cannot have beside a frame, AV_FRAME_DATA_... of FFmpeg's frame.h.

It frees a colour profile's name twice, which ends the process, and fails at kinds that it does not
know: enhancement layers, views, three-dimensional displays, and EXIF, as photographs have.
"""


class Harmless:
    """Frames of one video without what PyAV cannot have beside them, one at a time.

    Filters are made only for the first frame, and for one of another kind: that takes longer than
    what they do to a frame.
    """

    def __init__(self) -> None:
        self._kind: tuple[object, ...] = ()
        self._graph = Graph()

    def __call__(self, frame: av.VideoFrame) -> av.VideoFrame:
        """The same frame without it."""
        kind = frame.width, frame.height, frame.format.name, frame.time_base
        if kind != self._kind:
            self._kind, self._graph = kind, _filters(frame)
        self._graph.vpush(frame)
        return self._graph.vpull()


@dataclass(frozen=True)
class Turn:
    """A quarter turn, a mirroring, or both, by which a picture is shown.

    Parameters
    ----------
    swapped : bool
        Whether rows are shown as columns; that comes first.
    mirrored, flipped : bool
        Whether left and right, top and bottom change places.
    askew : bool
        Whether the file asks for another angle, or a slant; this is then the nearest turn.
    """

    swapped: bool = False
    mirrored: bool = False
    flipped: bool = False
    askew: bool = False

    @staticmethod
    def of(frame: av.VideoFrame, harmless: Harmless) -> Turn:
        """The turn of a frame's display matrix; none where it has no matrix."""
        beside: Any = harmless(frame).side_data  # PyAV's types know of motion vectors alone
        if Type.DISPLAYMATRIX not in beside:
            return Turn()
        return Turn.by(np.frombuffer(bytes(beside[Type.DISPLAYMATRIX]), np.int32))

    @staticmethod
    def by(display: NDArray[np.int32]) -> Turn:
        """The turn of a display matrix (9,), see FFmpeg's libavutil/display.h."""
        matrix = display.reshape(3, 3)
        # x' = a x + c y, y' = b x + d y, with x to the right and y down
        (a, b), (c, d) = matrix[:2, :2].astype(float)
        swapped = bool(abs(b) + abs(c) > abs(a) + abs(d))
        across, down = (c, b) if swapped else (a, d)
        rest = (a, d) if swapped else (b, c)
        askew = max(map(abs, rest)) > _ASKEW * max(abs(across), abs(down))
        return Turn(swapped, bool(across < 0), bool(down < 0), bool(askew))

    def __call__(self, picture: Frame) -> Frame:
        """A picture (H, W, 3) as it is shown, a view of it."""
        placed = picture.swapaxes(0, 1) if self.swapped else picture
        return placed[:: -1 if self.flipped else 1, :: -1 if self.mirrored else 1]


def pixel_aspect(stream: av.VideoStream) -> float:
    """Width of a stream's coded pixels over their height; 1 where the file does not say."""
    stated = float(stream.sample_aspect_ratio or 0) or 1.0
    believed = 1 / _LONGEST <= stated <= _LONGEST and abs(stated - 1) >= _SQUARE
    return stated if believed else 1.0


def shown_size(frame: av.VideoFrame, aspect: float, turn: Turn) -> tuple[int, int]:
    """Height and width of a frame as shown: stretched along the longer side of its pixels."""
    height, width = _stretched(frame, aspect)
    return (width, height) if turn.swapped else (height, width)


class Pictures:
    """The pictures of one video, made one at a time by one converter of colours.

    It keeps to one thread: by default FFmpeg shares each frame out to threads, and the shares wait
    for a core where others work, too: 2 to 4 ms for a picture of 0.03 ms.
    """

    def __init__(self) -> None:
        self._colours = VideoReformatter()

    def shown(self, frame: av.VideoFrame, aspect: float, turn: Turn) -> Frame:
        """A frame as shown, (H, W, 3) uint8 RGB; no row or column of what was coded is left out."""
        rgb = self._colours.reformat(frame, format="rgb24", threads=1)
        picture = np.asarray(rgb.to_ndarray(), np.uint8)
        height, width = _stretched(frame, aspect)
        if picture.shape[:2] != (height, width):
            picture = np.asarray(cv2.resize(picture, (width, height)), np.uint8)
        return np.ascontiguousarray(turn(picture), np.uint8)


def _filters(frame: av.VideoFrame) -> Graph:
    """Filters for frames of this one's kind."""
    graph = Graph()
    last = graph.add_buffer(
        width=frame.width, height=frame.height, format=frame.format,
        time_base=frame.time_base or Fraction(1),
    )  # fmt: skip
    for kind in _HARMFUL:
        without = graph.add("sidedata", f"mode=delete:type={kind}")
        last.link_to(without)
        last = without
    last.link_to(graph.add("buffersink"))
    graph.configure()
    return graph


def _stretched(frame: av.VideoFrame, aspect: float) -> tuple[int, int]:
    """Height and width with square pixels, before the frame is turned; even if it is stretched."""
    if aspect > 1:
        return frame.height, 2 * round(frame.width * aspect / 2)
    return (2 * round(frame.height / aspect / 2) if aspect < 1 else frame.height), frame.width
