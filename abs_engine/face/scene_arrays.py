"""Scenes as arrays of a file, and parts of a scene as facets of it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import ParameterError
from abs_engine.core.scene import Scene
from abs_engine.face.appearance.region import part
from abs_engine.face.talking_checks import same

SCENE_ARRAYS = ("mean", "modes", "faces", "uv", "facet_class", "texture", "cull")


def scene_arrays(scene: Scene) -> dict[str, Any]:
    """All of a scene; where its texture does not depend on the weights, that is empty."""
    layers = scene.texture_modes
    own = {name: getattr(scene, name) for name in SCENE_ARRAYS}
    return own | {"texture_modes": np.zeros(0, np.float32) if layers is None else layers}


def facets_of_part(whole: Scene, some: Scene) -> NDArray[np.bool_]:
    """Mask of the facets (F,) of a scene that `region.part` takes to make a part of it.

    Raises `ParameterError` if it is no such part.
    """
    chosen = np.zeros(len(whole.faces), np.bool_)
    if some.n_modes == whole.n_modes:
        corners = np.concatenate([_corners(whole), _corners(some)])
        ids = np.unique(corners, axis=0, return_inverse=True)[1].ravel()
        left = iter(ids[len(chosen) :])
        wanted = next(left)
        for facet, own in enumerate(ids[: len(chosen)]):
            if own == wanted:  # a part has its facets in the scene's order
                chosen[facet] = True
                wanted = next(left, -1)
    if not chosen.any() or not same(scene_arrays(part(whole, chosen)[0]), scene_arrays(some)):
        raise ParameterError(
            "what is compared of the face is not a part of its head", "take it by region.part"
        )
    return chosen


def _corners(scene: Scene) -> NDArray[np.int32]:
    """All that is known of each facet and its corners, bit for bit, (F, K)."""
    moved = scene.modes.transpose(1, 0, 2).reshape(len(scene.mean), -1)
    bits = np.concatenate([scene.mean, scene.uv, moved], axis=1).view(np.int32)
    known = bits[scene.faces].reshape(len(scene.faces), -1)
    return np.column_stack([known, scene.facet_class])
