"""A face's learned appearance, as the terms need it."""

from __future__ import annotations

from dataclasses import dataclass

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
    """

    model: LocalModel
    surface: Scene
    scale: float
