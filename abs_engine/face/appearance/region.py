"""The part of a head whose pixels are compared: the rendered set S (Odisio & Bailly, 3.2)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import MeshError
from abs_engine.core.scene import Scene


def part(scene: Scene, facets: NDArray[np.bool_]) -> tuple[Scene, NDArray[np.int64]]:
    """A scene of some facets (F,) only, with the same modes, texture and texture coordinates.

    And the scene's vertices that are in it, (V',), in their order. Facets left out hide nothing any
    more: keep what stands before S. Raises `MeshError` if none is kept, or they are of another
    scene.
    """
    chosen = np.asarray(facets, np.bool_)
    if chosen.shape != (len(scene.faces),) or not chosen.any():
        raise MeshError(
            f"{int(chosen.sum())} of {len(scene.faces)} facets are to be kept",
            "give true or false for each facet, and keep some",
        )
    kept, back = np.unique(scene.faces[chosen], return_inverse=True)
    smaller = replace(
        scene,
        mean=scene.mean[kept],
        modes=scene.modes[:, kept],
        faces=back.reshape(-1, 3).astype(np.int32),
        uv=scene.uv[kept],
        facet_class=scene.facet_class[chosen],
    )
    return smaller, kept.astype(np.int64)
