"""The part of a head whose pixels are compared: the rendered set S (Odisio & Bailly, 3.2)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import MeshError
from abs_engine.core.scene import Scene


def part(scene: Scene, facets: NDArray[np.bool_]) -> tuple[Scene, NDArray[np.int64]]:
    """A scene of some facets only, with the same modes, texture and texture coordinates.

    Parameters
    ----------
    scene : Scene
    facets : (F,) bool
        Which facets are kept. Those left out hide nothing any more: keep what stands before S.

    Returns
    -------
    tuple of Scene and (V',) int64
        The part, and the scene's vertices that are in it, in their order.

    Raises
    ------
    MeshError
        If no facet is kept, or `facets` is not of the scene.
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
