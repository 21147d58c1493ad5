"""Local appearance of a mouth's opening: what lies above, within, below and beside it.

For close-ups of a mouth, grey or in colour. The brightness about a pixel, taken at fixed places
around it and relative to its surroundings, says which side of the inner lips it lies on. Light,
beards and lipstick change how bright things are, hardly how they follow on each other.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.camera import Window
from abs_engine.face.appearance.luminance import luminance
from abs_engine.face.settings.appearance import APPEARANCE

SIDES = ("above", "inside", "below", "beside")
"""Above the upper inner lip, between the lips, below the lower one; beside the corners."""
ACROSS, SIZE, CENTRE = 64.0, (96, 88), (47.5, 38.0)
"""Pixels of the normalised picture across a mouth; its width and height; where the mouth lies."""
_ROWS = (-20, -16, -13, -10, -8, -6, -5, -4, -3, -2, -1, 0, 1, 2, 3, 4, 5, 6, 8, 10, 13, 16, 20)
_COLUMNS, _BETWEEN, _FAR = (-8, -4, 0, 4, 8), (-4, -2, 0, 2, 4), (-14, -2, 2, 14)
PLACES = (
    *((dx, dy) for dy in _ROWS for dx in _COLUMNS),
    *((dx, dy) for dy in _BETWEEN for dx in _FAR),
)
"""Columns and rows from a pixel to where brightness is taken: densest above and below it."""
_REACH = 24  # pixels that the places stay within
_DARK, _FLAT = 8.0, 0.05  # what is added to luminance, and to its spread, for noise to stay small
_NEAR, _AROUND = 16.0, 20.0  # pixels over which brightness and its spread are levelled


@dataclass(frozen=True)
class MouthSpot:
    """Approximate place of a mouth in a picture, and its width.

    Parameters
    ----------
    x, y : float, px
        Half-way between the corners.
    width : float, px
        From corner to corner.
    roll : float, radians
        By which the line of the corners is turned, clockwise as seen.
    """

    x: float
    y: float
    width: float
    roll: float = 0.0

    @classmethod
    def between(cls, left: FloatArray, right: FloatArray) -> MouthSpot:
        """Of the corners (2,), px, on the left and on the right of the picture."""
        (x, y), across = 0.5 * (left + right), right - left
        width, roll = float(np.hypot(*across)), float(np.arctan2(across[1], across[0]))
        return cls(float(x), float(y), width, roll)

    @cached_property
    def matrix(self) -> FloatArray:
        """From the normalised picture to pixels, (2, 3)."""
        s, (c, d) = self.width / ACROSS, (np.cos(self.roll), np.sin(self.roll))
        turned = s * np.array([[c, -d], [d, c]])
        return np.column_stack([turned, np.array([self.x, self.y]) - turned @ np.array(CENTRE)])

    def normalised(self, image: NDArray[np.generic]) -> NDArray[np.float32]:
        """The levelled logarithm of luminance (88, 96) about the mouth of a frame (H, W, 3)."""
        step = self.width / ACROSS
        smooth = cv2.GaussianBlur(luminance(image).astype(np.float32), (0, 0), max(0.4 * step, 0.3))
        flags, edge = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP, cv2.BORDER_REPLICATE
        patch = cv2.warpAffine(smooth, self.matrix, SIZE, flags=flags, borderMode=edge)
        level = np.log(patch + _DARK)
        level -= cv2.GaussianBlur(level, (0, 0), _NEAR)
        spread = np.sqrt(cv2.GaussianBlur(level * level, (0, 0), _AROUND))
        return np.asarray(cv2.GaussianBlur(level / (spread + _FLAT), (0, 0), 1.0), np.float32)

    def to_normalised(self, pixels: FloatArray) -> FloatArray:
        """Pixels (..., 2) of the frame in the normalised picture."""
        inverse = np.linalg.inv(self.matrix[:, :2])
        return np.asarray((pixels - self.matrix[:, 2]) @ inverse.T)

    def in_window(self, maps: FloatArray, window: Window) -> FloatArray:
        """Maps (C, 88, 96) of the normalised picture in a window, (C, h, w), bilinear."""
        grid = np.stack(np.meshgrid(*window.places), axis=-1)
        at = self.to_normalised(grid).astype(np.float32)
        edge = cv2.BORDER_REPLICATE
        return np.stack(
            [cv2.remap(m, at[..., 0], at[..., 1], cv2.INTER_LINEAR, borderMode=edge) for m in maps]
        )


def surroundings(picture: NDArray[np.float32]) -> NDArray[np.float32]:
    """Features of each pixel of a normalised picture, (88, 96, F): at `PLACES`, and its place."""
    height, width = picture.shape
    wide = np.pad(picture, _REACH, mode="edge")
    near = [
        wide[_REACH + dy : _REACH + dy + height, _REACH + dx : _REACH + dx + width]
        for dx, dy in PLACES
    ]
    y, x = np.mgrid[:height, :width].astype(np.float32)
    own = [x - CENTRE[0], y - CENTRE[1], np.abs(x - CENTRE[0])]
    return np.asarray(np.stack([*near, *own], axis=-1), np.float32)


@dataclass(frozen=True, eq=False)
class OpeningLooks:
    """A network of two hidden layers, from a pixel's surroundings to its side of the lips.

    `mean` and `spread` (F,) are of what it was learned from; `layers` are weights (M, N) and
    offsets (N,).
    """

    mean: NDArray[np.float32]
    spread: NDArray[np.float32]
    layers: tuple[tuple[NDArray[np.float32], NDArray[np.float32]], ...]

    def probabilities(self, image: NDArray[np.generic], spot: MouthSpot) -> FloatArray:
        """Probability of each pixel about a mouth to lie on each of `SIDES`, (4, 88, 96)."""
        seen = surroundings(spot.normalised(image))
        found = self.sides(seen.reshape(-1, seen.shape[-1]))
        maps = found.T.reshape(len(SIDES), *seen.shape[:2])
        return np.asarray((1 - APPEARANCE.doubt) * maps + APPEARANCE.doubt / len(SIDES), np.float64)

    def sides(self, seen: NDArray[np.float32]) -> NDArray[np.float32]:
        """The same of surroundings (N, F), (N, 4)."""
        out = (seen - self.mean) / self.spread
        for weights, offsets in self.layers[:-1]:
            out = np.maximum(out @ weights + offsets, 0)
        out = out @ self.layers[-1][0] + self.layers[-1][1]
        grown = np.exp(out - out.max(axis=1, keepdims=True))
        return np.asarray(grown / grown.sum(axis=1, keepdims=True), np.float32)

    def arrays(self) -> dict[str, Any]:
        """As they are kept in a file."""
        parts = {f"weights{k}": w for k, (w, _) in enumerate(self.layers)}
        parts |= {f"offsets{k}": b for k, (_, b) in enumerate(self.layers)}
        return {"mean": self.mean, "spread": self.spread, "layers": len(self.layers), **parts}

    @classmethod
    def of_arrays(cls, data: Mapping[str, Any]) -> OpeningLooks:
        """From a file's arrays; `KeyError` or `ValueError` where they do not fit together."""
        count = int(data["layers"])
        layers = tuple((data[f"weights{k}"], data[f"offsets{k}"]) for k in range(count))
        sizes = [len(PLACES) + 3, *(len(b) for _, b in layers)]
        fits = all(w.shape == (m, len(b)) for m, (w, b) in zip(sizes, layers, strict=False))
        shapes = data["mean"].shape == data["spread"].shape == (sizes[0],)
        whole = all(np.isfinite(part).all() for layer in layers for part in layer)
        if not (count > 0 and fits and shapes and whole and sizes[-1] == len(SIDES)):
            raise ValueError("its layers do not fit together")
        return cls(data["mean"], data["spread"], layers)
