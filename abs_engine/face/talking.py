"""A speaker's talking face: articulatory shape and the four appearance models of the paper."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from abs_engine.core.scene import Scene
from abs_engine.face.appearance.local import LocalModel
from abs_engine.face.appearance.texture import TextureModel
from abs_engine.face.articulated import FaceShape
from abs_engine.face.base import RINGS, Body, Face
from abs_engine.face.learned_appearance import LocalLooks, TextureLooks
from abs_engine.face.settings.appearance import APPEARANCE

TEXTURES, LOCALS = ("tex_lin", "tex_cst"), ("la_lin", "la_cst")
MODELS = ("tex_lin", "tex_cst", "la_lin", "la_cst")
"""Appearance models, in the order of figure 6."""


@dataclass(frozen=True)
class Noises:
    """The noise of a face's appearance, measured on training pictures that were left out.

    `noise` and `observations` of `TextureLooks`, and `local_learning.own_share`.
    """

    tex_noise: float
    tex_observations: float
    la_own_share: float


@dataclass(frozen=True, eq=False)
class TalkingFace:
    """A speaker-specific face: a shape and the four appearance models.

    Parameters
    ----------
    shape : FaceShape
    tex_lin, tex_cst : TextureModel
    la_lin, la_cst : LocalModel
        Their points are vertices of ``face.shape.outer``.
    la_scale : float
        Drawn pixels per image pixel at which local appearance was learned and is compared.
    noises : Noises or None
        None where they were not measured, as in files of earlier versions.
    """

    shape: FaceShape
    tex_lin: TextureModel
    tex_cst: TextureModel
    la_lin: LocalModel
    la_cst: LocalModel
    la_scale: float = 1.0
    noises: Noises | None = None

    @cached_property
    def dressed(self) -> dict[str, Scene]:
        """S with each texture, made once for all frames."""
        return {name: getattr(self, name).dress(self.shape.surface) for name in TEXTURES}


def as_face(face: TalkingFace) -> Face:
    """The face that a clip is tracked with: of each kind of appearance the linear model."""
    model, noises = face.tex_lin, face.noises or _unmeasured(face.tex_lin)
    drawn = face.shape.surface, face.dressed["tex_lin"]
    texture = TextureLooks(model, *drawn, noises.tex_noise, noises.tex_observations)
    local = LocalLooks(face.la_lin, face.shape.outer, face.la_scale, own_share=noises.la_own_share)
    looks = {"texture": texture, "local": local}
    return replace(shape_as_face(face.shape), appearance=looks)


def _unmeasured(model: TextureModel) -> Noises:
    """Noises of a face in whose file there are none, as earlier versions took them to be."""
    noise = float(np.sqrt(np.mean(model.leftover.spread.astype(np.float64) ** 2)))
    return Noises(noise, 0.0, APPEARANCE.alone)


def shape_as_face(shape: FaceShape) -> Face:
    """The face that a clip is tracked with, without any appearance."""
    own = {name: np.searchsorted(shape.kept, at) for name, at in shape.rings.items()}
    whole, rest = shape.scene, shape.scene.vertices(shape.neutral)
    body = Body(
        np.asarray(whole.mean, np.float32), np.asarray(whole.modes, np.float32), whole.faces,
        whole.facet_class, shape.regions,
        np.concatenate([shape.rings[n] for n in RINGS]).astype(np.int32),
        np.asarray(rest, np.float32),
    )  # fmt: skip
    return Face(
        "talking", shape.outer, shape.spec, shape.pivot, own,
        rest[shape.rings["outer"]].astype(np.float64),
        shape.neutral[None], shape.regions, body,
    )  # fmt: skip
