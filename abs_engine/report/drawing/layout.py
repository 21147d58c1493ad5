"""Captions, sheets of tiles, and pictures side by side."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image as Pillow
from PIL import ImageDraw, ImageFont

from abs_engine.core.arrays import Image

INK = (30, 30, 30)
PAPER = 255
FRAME = 200
GAP = 4


@lru_cache(maxsize=8)
def font(size: int) -> ImageFont.FreeTypeFont:
    """DejaVu Sans, which matplotlib brings along."""
    return ImageFont.truetype(
        str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf"), size
    )


def text_width(text: str, size: int) -> int:
    """Width of a line of text, pixels."""
    return int(np.ceil(font(size).getlength(text)))


def label(
    text: str,
    box: tuple[int, int],
    size: int = 13,
    *,
    align: str = "centre",
    ink: tuple[int, int, int] = INK,
) -> Image:
    """A line of text in a white box, (height, width, 3) uint8 RGB; smaller or cut if it is long.

    Parameters
    ----------
    box : tuple of int
        Width and height, pixels.
    size : int
        Height of the letters, pixels.
    align : {"centre", "left", "right"}
    """
    while size > 7 and text_width(text, size) > box[0] - 4:
        size -= 1
    while len(text) > 1 and text_width(text, size) > box[0] - 4:
        text = text[:-2] + "\N{HORIZONTAL ELLIPSIS}"
    picture = Pillow.new("RGB", box, (PAPER,) * 3)
    x, anchor = {"centre": (box[0] / 2, "mm"), "left": (2, "lm"), "right": (box[0] - 2, "rm")}[
        align
    ]
    ImageDraw.Draw(picture).text((x, box[1] / 2), text, ink, font(size), anchor)
    return np.asarray(picture, np.uint8)


def captioned(picture: Image, text: str, size: int = 13, ink: tuple[int, int, int] = INK) -> Image:
    """A picture with a line of text below it."""
    return np.concatenate([picture, label(text, (picture.shape[1], size + 9), size, ink=ink)])


def framed(picture: Image) -> Image:
    """A picture whose outermost pixels are a grey frame: how far the camera sees."""
    out = picture.copy()
    out[[0, -1]] = out[:, [0, -1]] = FRAME
    return out


def sheet(tiles: Sequence[Image], columns: int) -> Image:
    """Tiles of one size, row by row, on white."""
    high, wide = tiles[0].shape[:2]
    rows = -(-len(tiles) // columns)
    shape = rows * (high + GAP) + GAP, columns * (wide + GAP) + GAP, 3
    page = np.full(shape, PAPER, np.uint8)
    for place, tile in enumerate(tiles):
        y, x = GAP + (high + GAP) * (place // columns), GAP + (wide + GAP) * (place % columns)
        page[y : y + high, x : x + wide] = tile
    return page


def beside(pictures: Sequence[Image]) -> Image:
    """Pictures in a row, in the middle of the height of the highest."""
    height = max(p.shape[0] for p in pictures)
    left = [height - p.shape[0] for p in pictures]
    padded = (
        np.pad(p, ((n // 2, n - n // 2), (0, 0), (0, 0)), constant_values=PAPER)
        for p, n in zip(pictures, left, strict=True)
    )
    return np.concatenate([*padded], axis=1)


def stacked(pictures: Sequence[Image]) -> Image:
    """Pictures one below the other, in the middle of the width of the widest."""
    turned = [p.transpose(1, 0, 2) for p in pictures]
    return np.ascontiguousarray(beside(turned).transpose(1, 0, 2))


def columns_of(count: int, size: tuple[int, int]) -> int:
    """Number of columns that bring `count` tiles of a size near to a page 1.6 times as wide."""
    return max(1, min(count, round(float(np.sqrt(1.6 * count * size[1] / size[0])))))
