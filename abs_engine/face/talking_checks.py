"""Conditions that a talking face meets, whatever file it comes from."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

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


def conditions(face: TalkingFace) -> dict[str, bool]:
    """Conditions that may fail, and whether they hold."""
    shape, points, count = face.shape, len(face.shape.model.names), len(face.shape.model.predictors)
    numbers = {shape.scene.n_modes, len(shape.spec), shape.penalty.size}
    local = (face.la_lin, face.la_cst)
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
        "a texture is empty": shape.scene.texture.size > 0 and face.tex_lin.base.size > 0,
        "a texel was seen in fewer frames than none": bool((face.tex_lin.frames >= 0).all()),
        "a facet has no region": int(shape.scene.facet_class.max()) < len(shape.regions),
        "appearance depends on other parameters than the model's": all(
            len(model.modes) in (0, count) for model in (face.tex_lin, face.tex_cst, *local)
        ),
        "points of local appearance are not on the part that is drawn": all(
            _inside(model.vertices, len(shape.outer.mean)) for model in local
        ),
        "the scale of local appearance is not positive": face.la_scale > 0,
    }


def _inside(indices: NDArray[np.integer], count: int) -> bool:
    """Whether indices are a list of some that are not negative and below a count."""
    return indices.ndim == 1 and indices.size > 0 and 0 <= indices.min() <= indices.max() < count
