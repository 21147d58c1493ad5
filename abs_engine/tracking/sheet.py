"""The contact sheet: the mouth of many frames on one picture."""

from __future__ import annotations

import numpy as np

from abs_engine.core.arrays import Image
from abs_engine.tracking.clip_setting import ClipSetting, FrameResult
from abs_engine.tracking.contours import LEGEND, LOST, OTHERWISE, WHITE, LipDrawing, write_text
from abs_engine.tracking.run_table import closed_frames

MOST_TILES = 80
COLUMNS = 8
TILE = 240, 176
CAPTION = 22
ACROSS = 1.7  # mouth widths in a tile
_CLOSED = (255, 210, 90)


class ContactSheet:
    """Collects enlarged mouths with their contours; `picture` lays them out.

    Memory does not grow with the clip: tiles are thinned out as they come.
    """

    def __init__(self, setting: ClipSetting) -> None:
        self._drawing = LipDrawing.of(setting)
        self._tiles: list[Image] = []
        self._stride = 1
        self._seen = 0
        self._contradicted = False

    def add(self, image: Image, result: FrameResult) -> None:
        """Take a frame into account."""
        if self._seen % self._stride == 0:
            self._tiles.append(self.tile(image, result))
            if len(self._tiles) > 4 * MOST_TILES:
                self._tiles, self._stride = self._tiles[::2], 2 * self._stride
        self._seen += 1

    def tile(self, image: Image, result: FrameResult) -> Image:
        """One tile: the mouth, and below it frame number, aperture and whether it is closed."""
        width, height = TILE
        tile = np.zeros((height + CAPTION, width, 3), np.uint8)
        at = 6, height + 16
        if result.pose is None:
            write_text(tile, f"#{result.index}   {result.status}", at, LOST)
            return tile
        tile[:height] = self._drawing.view(result.pose, TILE, ACROSS).of(image, result)
        if not result.found:
            write_text(tile, f"#{result.index}   {result.status}", at, LOST)
            return tile
        closed = bool(closed_frames(result.aperture))
        text = f"#{result.index}   {result.aperture:.1f} mm{'   closed' if closed else ''}"
        plain = _CLOSED if closed else WHITE
        self._contradicted |= result.contradicted
        write_text(tile, text, at, LOST if result.contradicted else plain)
        return tile

    def picture(self) -> Image:
        """The sheet, (H, W, 3) uint8 RGB: all frames up to 80, else evenly spread ones.

        Its last line says what the lines' colours are, and how many of the frames it shows.
        """
        count = len(self._tiles)
        chosen = np.unique(np.linspace(0, count - 1, min(count, MOST_TILES)).round().astype(int))
        rows = -(-len(chosen) // COLUMNS)
        high, wide = TILE[1] + CAPTION, TILE[0]
        sheet = np.full((rows * (high + 2) + CAPTION, COLUMNS * (wide + 2), 3), 40, np.uint8)
        for place, index in enumerate(chosen):
            y, x = (high + 2) * (place // COLUMNS), (wide + 2) * (place % COLUMNS)
            sheet[y : y + high, x : x + wide] = self._tiles[index]
        words = [*LEGEND, (f"{len(chosen)} of {self._seen} frames", WHITE)]
        if self._contradicted:
            words.append((OTHERWISE, LOST))
        for k, (text, colour) in enumerate(words):
            write_text(sheet, text, (6 + k * (wide + 2), len(sheet) - 6), colour)
        return sheet
