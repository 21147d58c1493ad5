"""A mesh with morph targets, in the unit and the axes of its file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import ModelFormatError


@dataclass(frozen=True, eq=False)
class MorphMesh:
    """A mesh, its parts, and what it can be moved to.

    Parameters
    ----------
    source : str
        The file, as messages name it.
    vertices : (V, 3) float64
    faces : (F, 3) int32
    part : (F,) int32
        Index into `part_names`.
    part_names : tuple of str
        Names of groups, objects, meshes or materials.
    targets : mapping of str to (V, 3) float32
        Displacements at weight 1.
    components : mapping of str to (V, 3) float32
        Displacements by which people differ, at one standard deviation each.
    uv : (V, 2) float32, optional
        v down from the top of the texture.
    texture : (H, W, 3) uint8 RGB, optional
    model : str
        The published model that it is, "ict"; empty for any other.
    """

    source: str
    vertices: NDArray[np.float64]
    faces: NDArray[np.int32]
    part: NDArray[np.int32]
    part_names: tuple[str, ...]
    targets: Mapping[str, NDArray[np.float32]]
    components: Mapping[str, NDArray[np.float32]] = field(default_factory=dict)
    uv: NDArray[np.float32] | None = None
    texture: NDArray[np.uint8] | None = None
    model: str = ""


def displacement(
    name: str, moved: NDArray[np.floating], neutral: NDArray[np.floating]
) -> NDArray[np.float32]:
    """By how much a target moves each vertex, (V, 3).

    Raises
    ------
    ModelFormatError
        If it has another number of vertices than the neutral mesh.
    """
    if len(moved) != len(neutral):
        raise ModelFormatError(
            f"morph target '{name}' has {len(moved)} vertices, the head has {len(neutral)}",
            "export all of them from one mesh, without merging or splitting vertices",
        )
    return np.asarray(moved - neutral, np.float32)
