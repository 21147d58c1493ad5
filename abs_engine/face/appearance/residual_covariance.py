"""The covariance of what a texture model leaves out of luminance-normalised frames."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.face.appearance.atlas import Atlas
from abs_engine.face.appearance.regression import Frames
from abs_engine.face.settings.appearance import APPEARANCE

T = TypeVar("T", np.float32, np.float64)


def normalised(rgb: NDArray[T]) -> NDArray[T]:
    """Luminance-normalised RGB (..., 3), as `core.scene.ColourError` has it; RGB is 0 to 255."""
    rgb = np.asarray(rgb, np.result_type(rgb, np.float32))  # of integers only zeros would be left
    return np.asarray((rgb + 1) / (rgb.sum(axis=-1, keepdims=True) + 3), rgb.dtype)


@dataclass(frozen=True, eq=False)
class Leftover:
    """By how much luminance-normalised frames are off what the other frames foretell.

    Parameters
    ----------
    spread : (H, W) float32
        Standard deviation of a texel's channels, of what it does not have in common with others.
    common : (q, H, W, 3) float32, in units of `spread`
        The strongest directions of what is left of all texels together, each times its root mean
        square over the frames: where lips roll in, or light falls otherwise, many are off alike.

    Notes
    -----
    In common is one share of the variance of all texels, that of these directions: each texel's own
    share, of so few frames, is not known.
    """

    spread: NDArray[np.float32]
    common: NDArray[np.float32]

    @cached_property
    def layers(self) -> NDArray[np.float32]:
        """One over `spread`, then `common`, (H, W, 1 + 3 q): what a pixel reads lies together."""
        height, width = self.spread.shape
        common = self.common.transpose(1, 2, 0, 3).reshape(height, width, -1)
        return np.dstack([1 / floored(self.spread), common]).astype(np.float32)


def leftover(frames: Frames, ridge: float, atlas: Atlas) -> Leftover:
    """Measure it on training frames, each left out of the fit, with its ridge, in turn.

    The frames are luminance-normalised values of the atlas' texels. Texels that too few frames show
    have the spread of the nearest of their class, and no part in what is common. Where all are
    shown by too few nothing is known: 1, and nothing in common.
    """
    count = frames.seen.sum(axis=0)
    known = count >= APPEARANCE.frames_each * (frames.parameters.shape[1] + 1)
    size = atlas.facet_id.shape
    if not known.any():
        return Leftover(np.ones(size, np.float32), np.zeros((0, *size, 3), np.float32))
    off = frames.of(known).left_out(ridge)
    wide = np.zeros(len(known))
    wide[known] = np.sqrt((off**2).sum(axis=0).mean(axis=1) / count[known])
    scaled = floored(wide[known])
    rows = off / scaled[:, None]
    modes = _strongest(rows.reshape(len(rows), -1))
    own = np.sqrt(max(1 - (modes**2).sum() / (rows**2).mean(axis=0).sum(), APPEARANCE.least_own))
    wide[known] = own * scaled
    spread = atlas.picture(wide[:, None], known)[..., 0]
    layers = np.zeros((min(APPEARANCE.common, len(rows)), *size, 3), np.float32)
    for layer, mode in zip(layers, modes / own, strict=False):
        values = np.zeros((len(known), 3))
        values[known] = mode.reshape(-1, 3)
        layer[atlas.texels] = values
    return Leftover(spread, layers)


def floored(spread: NDArray[T]) -> NDArray[T]:
    """Spreads, of which none counts as less than a share of their median."""
    return np.asarray(
        np.maximum(spread, APPEARANCE.least_spread * np.median(spread) + 1e-6), spread.dtype
    )


def _strongest(rows: FloatArray) -> FloatArray:
    """Principal directions (q, K) of rows (T, K), each times its root mean square."""
    _, axes = np.linalg.eigh(rows @ rows.T)
    return np.asarray(axes[:, ::-1][:, : APPEARANCE.common].T @ rows / np.sqrt(len(rows)))
