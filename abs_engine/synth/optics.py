"""What is behind the head, and what lens and sensor make of the picture."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
Floats = NDArray[np.float32]


@dataclass(frozen=True)
class Sensor:
    """Blur and noise of a camera.

    Parameters
    ----------
    blur : float
        Standard deviation of the lens blur in pixels; 0 is off.
    shot : float
        Standard deviation of the shot noise at full white, in grey levels of 255; it grows
        with the square root of the signal.
    read : float
        Standard deviation of the read noise, in grey levels.
    """

    blur: float = 0.45
    shot: float = 2.5
    read: float = 1.0

    def expose(self, ideal: Floats, rng: np.random.Generator) -> Picture:
        """A picture as the sensor gives it, (H, W, 3) uint8, from float32 colours 0 to 255."""
        seen = cv2.GaussianBlur(ideal, (0, 0), self.blur) if self.blur > 0 else ideal
        spread = np.sqrt(self.shot**2 * np.clip(seen, 0, 255) / 255 + self.read**2)
        noisy = seen + spread * rng.standard_normal(seen.shape, np.float32)
        return np.asarray(np.clip(np.rint(noisy), 0, 255), np.uint8)


def backdrop(
    size: tuple[int, int], top: tuple[float, float, float], bottom: tuple[float, float, float]
) -> Floats:
    """A vertical gradient with a soft vignette, (H, W, 3) float32, 0 to 255."""
    width, height = size
    down = np.linspace(0, 1, height, dtype=np.float32)[:, None, None]
    across = np.linspace(-1, 1, width, dtype=np.float32)[None, :, None]
    ends = np.array([top, bottom], np.float32)
    colour = (1 - down) * ends[0] + down * ends[1]
    return np.asarray(colour * (1 - 0.18 * (across**2 + (2 * down - 1) ** 2)), np.float32)


def composite(rgba: Picture, behind: Floats) -> Floats:
    """Lay a multisampled drawing (alpha: coverage, colours premultiplied) over a picture."""
    drawn = rgba.astype(np.float32)
    return np.asarray(drawn[..., :3] + behind * (1 - drawn[..., 3:] / 255), np.float32)
