"""Conditions that a talking face meets, whatever file it comes from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import astuple
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.face.articulated import FaceShape
from abs_engine.face.base import RINGS
from abs_engine.face.talking import TalkingFace

_RINGS = {*RINGS, "points", "corners"}


def same(one: Mapping[str, Any], two: Mapping[str, Any]) -> bool:
    """Whether arrays are the same by name, bit for bit."""
    pairs = [(np.asarray(one[name]), np.asarray(two[name])) for name in one]
    return all(
        a is b or ((a.dtype, a.shape) == (b.dtype, b.shape) and a.tobytes() == b.tobytes())
        for a, b in pairs
    )


def conditions(
    shape: FaceShape, face: TalkingFace | None, neutral: NDArray[np.floating] | None
) -> dict[str, bool]:
    """Conditions that may fail, and whether they hold."""
    own = {} if face is None else _of_appearance(face)
    if neutral is not None:
        fits = neutral.dtype == np.float32 and neutral.shape == shape.scene.mean.shape
        own["the head at rest has other vertices than the head"] = fits
    return _of_shape(shape) | own


def _of_shape(shape: FaceShape) -> dict[str, bool]:
    points, count = len(shape.model.names), len(shape.model.predictors)
    numbers = {shape.scene.n_modes, len(shape.spec), shape.penalty.size}
    return {
        "the head, the penalty or the bounds have other parameters than the model": (
            numbers == {count} and shape.neutral.shape == (count,)
        ),
        "the vertices are not one for each point of the model": (
            shape.vertices.shape == (points,) and _inside(shape.vertices, len(shape.scene.mean))
        ),
        "the points of the lips are not the model's": _inside(shape.lips, points),
        "the marks are not on the head": _inside(shape.marks, len(shape.scene.mean)),
        "the lips' contours are not on the part that is drawn": (
            shape.rings.keys() >= _RINGS
            and all(
                _inside(at, len(shape.scene.mean)) and np.isin(at, shape.kept).all()
                for at in shape.rings.values()
            )
        ),
        "a texture is empty": shape.scene.texture.size > 0,
        "a facet has no region": int(shape.scene.facet_class.max()) < len(shape.regions),
    }


def _of_appearance(face: TalkingFace) -> dict[str, bool]:
    count, local = len(face.shape.model.predictors), (face.la_lin, face.la_cst)
    return {
        "a texture is empty": face.shape.scene.texture.size > 0 and face.tex_lin.base.size > 0,
        "a texel was seen in fewer frames than none": bool((face.tex_lin.frames >= 0).all()),
        "appearance depends on other parameters than the model's": all(
            len(model.modes) in (0, count) for model in (face.tex_lin, face.tex_cst, *local)
        ),
        "points of local appearance are not on the part that is drawn": all(
            _inside(model.vertices, len(face.shape.outer.mean)) for model in local
        ),
        "the scale of local appearance is not positive": face.la_scale > 0,
        "the noise of the appearance is not positive, or a share is above 1": (
            face.noises is None or (min(astuple(face.noises)) > 0 and face.noises.la_own_share <= 1)
        ),
    }


def _inside(indices: NDArray[np.integer], count: int) -> bool:
    """Whether indices are a list of some that are not negative and below a count."""
    return indices.ndim == 1 and indices.size > 0 and 0 <= indices.min() <= indices.max() < count
