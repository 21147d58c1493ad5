"""A speaker's talking face: articulatory shape and the four appearance models of the paper."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from abs_engine.appearance.atlas import fitting_size, lay_atlas
from abs_engine.appearance.choose import N_POINTS
from abs_engine.appearance.information import choose_informative, information
from abs_engine.appearance.local import LocalModel, learn_local
from abs_engine.appearance.sight import Sighting
from abs_engine.appearance.texture import TextureModel, learn_texture
from abs_engine.camera import Camera
from abs_engine.errors import ParameterError
from abs_engine.scene import Renderer, Scene
from abs_engine.systems.articulatory.filmed import VisemePictures
from abs_engine.systems.articulatory.shape import FaceShape

FloatArray = NDArray[np.float64]
TEXTURES, LOCALS = ("tex_lin", "tex_cst"), ("la_lin", "la_cst")
MODELS = ("tex_lin", "tex_cst", "la_lin", "la_cst")
"""Appearance models, in the order of figure 6."""
SPACING = 4.0
"""mm between the points of local appearance, at least."""
FINEST = 1.0
"""Drawn pixels per mm of local appearance, at most: its filters are to reach 2 mm and more, or a
fit that starts far away does not come home."""


def _known(name: str, names: tuple[str, ...]) -> str:
    if name not in names:
        raise ParameterError(f"there is no model '{name}'", f"choose of {', '.join(names)}")
    return name


@dataclass(frozen=True, eq=False)
class TalkingFace:
    """A speaker-specific face: a shape and the four appearance models.

    Parameters
    ----------
    shape : FaceShape
    tex_lin, tex_cst : TextureModel
    la_lin, la_cst : LocalModel
        Their points are vertices of ``shape.outer``.
    la_scale : float
        Drawn pixels per image pixel at which local appearance was learned and is compared.
    """

    shape: FaceShape
    tex_lin: TextureModel
    tex_cst: TextureModel
    la_lin: LocalModel
    la_cst: LocalModel
    la_scale: float = 1.0

    def texture(self, name: str) -> TextureModel:
        """A texture model by its name.

        Raises
        ------
        ParameterError
            If there is no such model.
        """
        return {"tex_lin": self.tex_lin, "tex_cst": self.tex_cst}[_known(name, TEXTURES)]

    def local(self, name: str) -> LocalModel:
        """A model of local appearance by its name.

        Raises
        ------
        ParameterError
            If there is no such model.
        """
        return {"la_lin": self.la_lin, "la_cst": self.la_cst}[_known(name, LOCALS)]

    @cached_property
    def dressed(self) -> dict[str, Scene]:
        """S with each texture, made once for all frames."""
        return {name: self.texture(name).dress(self.shape.surface) for name in TEXTURES}


def sightings(shape: FaceShape, pictures: VisemePictures, alpha: FloatArray) -> list[Sighting]:
    """Pictures with the geometry that the articulatory model gives them.

    Parameters
    ----------
    shape : FaceShape
    pictures : VisemePictures
    alpha : (V, P) float64
        Parameters of the visemes.
    """
    return [
        Sighting(picture, shape.scene.vertices(row), pose, row)
        for picture, pose, row in zip(pictures.pictures, pictures.poses, alpha, strict=True)
    ]


def learn_face(
    shape: FaceShape,
    seen: Sequence[Sighting],
    camera: Camera,
    renderer: Renderer,
    *,
    count: int = N_POINTS,
) -> TalkingFace:
    """Learn the four appearance models from pictures of known geometry.

    Parameters
    ----------
    shape : FaceShape
    seen : sequence of Sighting
        Of ``shape.scene``; see `sightings`.
    camera : Camera
    renderer : Renderer
    count : int
        Points of local appearance; the paper's N is 63.

    Raises
    ------
    NothingSeenError
        If the pictures do not show the face.
    ParameterError
        If there are no pictures.
    """
    if not seen:
        raise ParameterError("there are no pictures to learn from", "give some")
    textured = shape.scene
    atlas = lay_atlas(textured, fitting_size(textured, camera, seen[0].pose), renderer)
    tex = learn_texture(seen, textured, atlas, camera, renderer)
    depth = float(seen[0].pose.apply(shape.pivot)[2])
    scale = min(1.0, FINEST * depth / float(camera.matrix[0, 0]))
    every = learn_local(seen, textured, shape.marks, camera, renderer, scale=scale)
    places = textured.mean[shape.marks].astype(np.float64)
    told = information(every, seen, textured, camera, renderer, shape.moved, scale)
    chosen = choose_informative(every, told, shape.about, count, places, SPACING)
    local = every.only(chosen).within(shape.kept)
    return TalkingFace(shape, tex, tex.constant(), local, local.constant(), scale)


def learned_from(face: TalkingFace, **models: TextureModel | LocalModel) -> TalkingFace:
    """The same face with other appearance models, such as ``tex_cst`` of a single picture."""
    return replace(face, **models)  # type: ignore[arg-type]
