"""A face's learned appearance, as the terms need it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from abs_engine.core.scene import Scene
from abs_engine.face.appearance.local import LocalModel
from abs_engine.face.appearance.texture import TextureModel


@dataclass(frozen=True, eq=False)
class TextureLooks:
    """A face's texture.

    Parameters
    ----------
    model : TextureModel
    surface : Scene
        What is compared of the face: skin and lips.
    dressed : Scene
        The same with the texture.
    noise : float
        Standard deviation, luminance-normalised, of what the model leaves unexplained.
    """

    model: TextureModel
    surface: Scene
    dressed: Scene
    noise: float


@dataclass(frozen=True, eq=False)
class LocalLooks:
    """A face's local appearance.

    Parameters
    ----------
    model : LocalModel
        Its points are vertices of `surface`.
    surface : Scene
        What hides and is hidden.
    scale : float
        Drawn pixels per image pixel at which it was learned.
    per_mm : float
        Drawn pixels per mm at which it was learned, where clips of any camera and distance are
        compared at that; 0 where they are compared at `scale`.
    """

    model: LocalModel
    surface: Scene
    scale: float
    per_mm: float = 0.0

    def scale_at(self, pixel: float) -> float:
        """Drawn pixels per image pixel for a head of so many image pixels per mm."""
        return self.per_mm / pixel if self.per_mm else self.scale


@dataclass(frozen=True, eq=False)
class Appearance:
    """Appearance that was learned of a head.

    Parameters
    ----------
    texture : TextureModel
        `tex_lin`; its constant is `tex_cst`.
    local : LocalModel
        `la_lin`; its points are vertices of the whole head.
    per_mm : float
        Pixels per mm at which both were learned, at the depth of the mouth.
    """

    texture: TextureModel
    local: LocalModel
    per_mm: float

    @property
    def texture_noise(self) -> float:
        """Standard deviation of what the texture leaves unexplained, luminance-normalised.

        Over what was seen of the surface, with what texels miss alike.
        """
        left, seen = self.texture.leftover, self.texture.frames > 0
        share = 1 + (left.common.astype(np.float64) ** 2).sum(axis=0).mean(axis=-1)
        return float(np.sqrt(np.mean((left.spread.astype(np.float64) ** 2 * share)[seen])))
