"""A face's learned appearance, as the terms need it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from abs_engine.core.arrays import FloatArray
from abs_engine.core.scene import Scene
from abs_engine.face.appearance.local import LocalModel
from abs_engine.face.appearance.texture import TextureModel
from abs_engine.face.settings.appearance import APPEARANCE


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
    observations : float
        Number of independent ones that a picture is worth, where that was measured; 0 where they
        are counted as those of colours are.
    """

    model: TextureModel
    surface: Scene
    dressed: Scene
    noise: float
    observations: float = 0.0


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
    own_share : float
        See `local_learning.own_share`.
    """

    model: LocalModel
    surface: Scene
    scale: float
    per_mm: float = 0.0
    own_share: float = APPEARANCE.alone

    def scale_at(self, pixel: float) -> float:
        """Drawn pixels per image pixel for a head of so many image pixels per mm."""
        return self.per_mm / pixel if self.per_mm else self.scale

    @cached_property
    def whitener(self) -> FloatArray:
        """Matrix (8 N, 8 N) that makes the noise of all descriptors white."""
        usual = self.own_share == APPEARANCE.alone  # of which the model keeps it
        return self.model.whitener if usual else self.model.whitened_by(self.own_share)


@dataclass(frozen=True, eq=False)
class Appearance:
    """Appearance that was learned of a head, from several recordings.

    Parameters
    ----------
    texture : TextureModel
        `tex_lin`; its constant is `tex_cst`.
    local : LocalModel
        `la_lin`; its points are vertices of the whole head.
    per_mm, texture_per_mm : float
        Pixels per mm at which they were learned, at the depth of the mouth.
    texture_noise : float
        Standard deviation of luminance-normalised frames about the texture that other recordings
        foretell.
    texture_observations : float
        Number of independent observations of that noise that a frame is worth: its sum of squares
        varies from frame to frame as that of so many does (Satterthwaite, Biometrics 1946).
    own_share : float
        See `local_learning.own_share`.
    """

    texture: TextureModel
    local: LocalModel
    per_mm: float
    texture_per_mm: float
    texture_noise: float
    texture_observations: float
    own_share: float
