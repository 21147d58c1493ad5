"""Background, lens and sensor of a filmed picture."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import Float32Array, Image
from abs_engine.core.camera import Camera
from abs_engine.core.errors import ParameterError
from abs_engine.io.pictures import read_image

Colour = tuple[float, float, float]


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
    bands : float
        Height, in grey levels, of the horizontal bands that roll through the pictures, as lamps
        on mains current and a rolling shutter make them; 0 is off.
    band_period : float
        Pixels from band to band.
    band_speed : float
        Pixels by which the bands move down from frame to frame.

    Raises
    ------
    ParameterError
        If a value is negative.
    """

    blur: float = 0.45
    shot: float = 2.5
    read: float = 1.0
    bands: float = 0.0
    band_period: float = 80.0
    band_speed: float = 7.0

    def __post_init__(self) -> None:
        if min(self.blur, self.shot, self.read, self.bands) < 0 or self.band_period <= 0:
            raise ParameterError(
                "blur, noise and bands cannot be negative", "give 0 to leave it out"
            )

    def expose(
        self, ideal: Float32Array, rng: np.random.Generator, frame: int = 0, blur: float = 0.0
    ) -> Image:
        """A picture as the sensor gives it, (H, W, 3) uint8.

        Parameters
        ----------
        ideal : (H, W, 3) float32, 0 to 255
        rng : numpy.random.Generator
            Of the noise.
        frame : int
            Where the rolling bands are.
        blur : float
            More blur than the lens has, pixels.
        """
        spread = float(np.hypot(self.blur, blur))
        seen = cv2.GaussianBlur(ideal, (0, 0), spread) if spread > 0 else ideal
        if self.bands > 0:
            rows = np.arange(len(seen), dtype=np.float32) - np.float32(self.band_speed * frame)
            wave = np.sin(2 * np.pi / self.band_period * rows).astype(np.float32)
            seen = seen + np.float32(self.bands) * wave[:, None, None]
        noise = np.sqrt(self.shot**2 * np.clip(seen, 0, 255) / 255 + self.read**2)
        noisy = seen + noise * rng.standard_normal(seen.shape, np.float32)
        return np.asarray(np.clip(np.rint(noisy), 0, 255), np.uint8)


@dataclass(frozen=True)
class Background:
    """Background far behind the head: a gradient with a soft vignette.

    Parameters
    ----------
    top, bottom : tuple of float
        Colours, 0 to 255.
    clutter : float
        Height, in grey levels, of soft blobs of colour, as of a room out of focus; 0 is off.
    picture : str
        A picture file that is laid behind the head instead; '' is off.

    Raises
    ------
    ParameterError
        If a colour is not 0 to 255, or the clutter negative.
    """

    top: Colour = (118.0, 128.0, 134.0)
    bottom: Colour = (74.0, 82.0, 90.0)
    clutter: float = 0.0
    picture: str = ""

    def __post_init__(self) -> None:
        levels = (*self.top, *self.bottom)
        if not 0 <= min(levels) <= max(levels) <= 255 or self.clutter < 0:
            raise ParameterError(
                "a colour of the background is not 0 to 255, or its clutter is negative",
                "give colours of 0 to 255, and a clutter of 0 or more",
            )


def backdrop(camera: Camera, background: Background, seed: int = 0) -> Float32Array:
    """The background as a camera and its lens see it, (H, W, 3) float32, 0 to 255.

    Parameters
    ----------
    seed : int
        Of the clutter.

    Raises
    ------
    InputFileError
        If there is no such picture.
    """
    width, height = camera.size
    across, down = np.arange(width, dtype=np.float64), np.arange(height, dtype=np.float64)
    grid: NDArray[np.float64] = np.stack(np.meshgrid(across, down), axis=-1)
    if camera.distorted:  # where an ideal lens would have put each pixel
        focal, centre = camera.matrix[[0, 1], [0, 1]], camera.matrix[:2, 2]
        grid = camera.undistort(grid) * focal + centre
    place = (grid / [max(width - 1, 1), max(height - 1, 1)]).astype(np.float32)
    if background.picture:
        image = cv2.resize(
            read_image(Path(background.picture)), (width, height), interpolation=cv2.INTER_AREA
        )
        x, y = (np.ascontiguousarray(grid[..., k], np.float32) for k in range(2))
        seen = cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
        return np.asarray(seen, np.float32)
    low, aside = place[..., 1:], 2 * place[..., :1] - 1
    ends = np.array([background.top, background.bottom], np.float32)
    colour = (1 - low) * ends[0] + low * ends[1]
    if background.clutter > 0:
        colour = colour + np.float32(background.clutter) * _blobs(place, seed)
    dark = 1 - 0.18 * (aside**2 + (2 * low - 1) ** 2)
    return np.asarray(np.clip(colour * dark, 0, 255), np.float32)


def _blobs(place: Float32Array, seed: int) -> Float32Array:
    """Smooth noise (H, W, 3) of about unit height at places (H, W, 2)."""
    rng = np.random.default_rng([seed, 77])
    out = np.zeros((*place.shape[:2], 3), np.float32)
    for _ in range(24):
        middle, radius = rng.uniform(-0.1, 1.1, 2), rng.uniform(0.05, 0.25)
        colour = rng.normal(0, 0.6, 3).astype(np.float32)
        away = ((place - middle) ** 2).sum(axis=-1, keepdims=True) / radius**2
        out += colour * np.exp(-(away**2)).astype(np.float32)
    return out


def composite(rgba: Image, behind: Float32Array) -> Float32Array:
    """Lay a multisampled drawing (alpha: coverage, colours premultiplied) over a picture."""
    drawn = rgba.astype(np.float32)
    return np.asarray(drawn[..., :3] + behind * (1 - drawn[..., 3:] / 255), np.float32)
