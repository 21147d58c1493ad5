"""The overlay video: the frame with the lips drawn on it, the mouth enlarged, and the aperture."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from abs_engine.core.arrays import Image
from abs_engine.core.camera import Window
from abs_engine.core.threads import Behind
from abs_engine.io.assets import CLOSED_APERTURE
from abs_engine.io.video import VideoWriter
from abs_engine.tracking.frame.clip_setting import ClipSetting, FrameResult
from abs_engine.tracking.results.contours import (
    GREY,
    LEGEND,
    LOST,
    OTHERWISE,
    OUTER,
    WHITE,
    LipDrawing,
    MouthView,
    write_text,
)  # fmt: skip
from abs_engine.tracking.results.run_table import closed_frames

OVERLAY = "overlay"  # what it is called among what frames cost
LEAST_HEIGHT = 576  # of the drawn frame
PANEL_WIDTH = 448
ACROSS = 2.2  # mouth widths in the panel
STRIP_HEIGHT = 96
STRIP_SECONDS = 4.0
STRIP_MM = 25.0  # aperture at the strip's top, or a multiple that holds the widest
_BELOW = f"closed below {CLOSED_APERTURE:g} mm"
_CODING = 24, "ultrafast"  # x264's quantiser and preset: half of the time


class Overlay:
    """Writes ``overlay.mp4``, a frame at a time; a context manager.

    Frames that are unevenly spaced are shown at their own times.

    Parameters
    ----------
    also : callable, optional
        Called with each frame and its result after the frame was written, in the same thread.
    """

    def __init__(
        self,
        path: Path,
        setting: ClipSetting,
        also: Callable[[Image, FrameResult], None] | None = None,
    ) -> None:
        self._also = also
        self._painter = Painter(setting)
        self._times = self._painter.times
        uneven = bool(self._times)
        self._writer = VideoWriter(
            path, self._painter.size, setting.rate, *_CODING, uneven, quick=True
        )
        self._behind, self._clock = Behind(), setting.clock

    def add(self, image: Image, result: FrameResult) -> None:
        """Append a frame; it is drawn and written beside other work."""
        self._behind.call(self._append, image, result)

    def _append(self, image: Image, result: FrameResult) -> None:
        with self._clock.part(OVERLAY):
            shown = self._times[result.index : result.index + 1]
            time = shown[0] - self._times[0] if shown else None
            self._writer.write(self._painter.paint(image, result), time)
            if self._also is not None:
                self._also(image, result)

    def __enter__(self) -> Overlay:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        try:
            self._behind.__exit__(kind)
        finally:
            self._writer.close()


class Painter:
    """Draws overlay pictures; remembers where the mouth was and the last seconds' apertures."""

    def __init__(self, setting: ClipSetting) -> None:
        width, height = setting.camera.size
        scale = max(1.0, LEAST_HEIGHT / height)
        self._whole = Window(0, 0, width, height, scale)
        self._drawing = LipDrawing.of(setting)
        self._rate = setting.rate
        self.times = setting.uneven_times  # when each frame is shown, s
        self._panel: MouthView | None = None
        drawn_width, drawn_height = (2 * (n // 2) for n in self._whole.drawn)
        self._frame = drawn_width, drawn_height
        self._crop = PANEL_WIDTH, 2 * (drawn_height // 4)
        self.size = drawn_width + PANEL_WIDTH, drawn_height + STRIP_HEIGHT
        self._shown = max(2, round(STRIP_SECONDS * setting.rate)) - 1  # frames before this one
        self._apertures: deque[tuple[float, float]] = deque()  # where each is on the strip, first

    def paint(self, image: Image, result: FrameResult) -> Image:
        """The overlay picture of a frame, (H, W, 3) uint8 RGB; its size is `size`."""
        now = self._place(result.index)
        self._apertures.append((now, result.aperture))
        while now - self._apertures[0][0] > self._shown:
            self._apertures.popleft()
        picture = np.zeros((self.size[1], self.size[0], 3), np.uint8)
        width, height = self._frame
        picture[:height, :width] = self._large(image, result)[:height, :width]
        picture[:height, width:] = self._mouth(image, result)
        picture[height:] = self._strip()
        return picture

    def _place(self, index: int) -> float:
        """A frame's time, in steps of the rate."""
        return self.times[index] * self._rate if index < len(self.times) else index

    def _large(self, image: Image, result: FrameResult) -> Image:
        """The whole frame with contours and what is known about it."""
        # Quicker than cutting a window out, which this one need not be
        picture = np.asarray(cv2.resize(image, self._whole.drawn), np.uint8)
        self._drawing.draw(picture, self._whole, result)
        write_text(
            picture, f"#{result.index}   {self._place(result.index) / self._rate:.2f} s", (10, 22)
        )
        if result.found:
            mark = "   closed" if closed_frames(result.aperture) else ""
            sure = "" if result.belief is None else f" (sd {result.belief.aperture:.1f})"
            write_text(picture, f"aperture {result.aperture:.1f}{sure} mm{mark}", (10, 44))
            if result.contradicted:
                write_text(picture, OTHERWISE, (10, 66), LOST)
        else:
            cv2.rectangle(picture, (2, 2), (self._frame[0] - 3, self._frame[1] - 3), LOST, 3)
            write_text(picture, result.status, (10, 44), LOST)
        return picture

    def _mouth(self, image: Image, result: FrameResult) -> Image:
        """The enlarged mouth with contours, and below it as it is."""
        if result.pose is not None:
            self._panel = self._drawing.view(result.pose, self._crop, ACROSS, self._panel)
        panel = np.zeros((self._frame[1], PANEL_WIDTH, 3), np.uint8)
        if self._panel is None:
            return panel
        plain, drawn = self._panel.of(image, result)
        for line, (name, colour) in enumerate(LEGEND if result.found else ()):
            write_text(drawn, name, (8, 18 + 16 * line), colour, 0.4)
        height = self._crop[1]
        panel[:height], panel[height : 2 * height] = drawn, plain
        return panel

    def _strip(self) -> Image:
        """The aperture over the last seconds; the right end is now."""
        width = self.size[0]
        strip = np.full((STRIP_HEIGHT, width, 3), 24, np.uint8)
        bottom, top = STRIP_HEIGHT - 8, 8
        places, values = np.array(self._apertures).T
        x = width - 1 - (width - 1) / self._shown * (places[-1] - places)
        most = STRIP_MM * max(1.0, np.ceil(np.fmax.reduce(values) / STRIP_MM))
        y = bottom - values / most * (bottom - top)
        limit = round(bottom - CLOSED_APERTURE / most * (bottom - top))
        cv2.line(strip, (0, limit), (width, limit), GREY, 1)
        write_text(strip, _BELOW, (8, limit - 4), GREY, 0.4)
        lines = np.split(np.column_stack([x, y]), np.flatnonzero(~np.isfinite(values)))
        fixed = [np.rint(p[np.isfinite(p[:, 1])] * 16).astype(np.int32) for p in lines]
        alone = np.array([[-24, 0], [24, 0]], np.int32)  # a dash
        seen = [p + alone if len(p) == 1 else p for p in fixed if len(p)]
        cv2.polylines(strip, seen, False, OUTER, 1, cv2.LINE_AA, 4)
        write_text(
            strip, f"aperture, last {STRIP_SECONDS:.0f} s, 0 to {most:.0f} mm", (8, 20), WHITE
        )
        return strip
