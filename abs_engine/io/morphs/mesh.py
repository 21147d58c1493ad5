"""A mesh with morph targets, in the unit and the axes of its file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray
from abs_engine.core.errors import ModelFormatError
from abs_engine.io.arrays import check_arrays, real


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
    uv : (F, 3, 2) float32, optional
        Of each facet's corners, 0 to 1, v down from the top of the texture.
    texture : (H, W, 3) uint8 RGB, optional
        All materials' pictures side by side.
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

    def at_seams(self) -> tuple[MorphMesh, NDArray[np.int64]]:
        """The mesh with vertices that have one place on the texture each, and what they were.

        Vertices keep their numbers; copies for their other places come behind.
        """
        if self.uv is None:
            return self, np.arange(len(self.vertices))
        corner = self.faces.ravel().astype(np.int64)
        rows = np.column_stack([corner, np.round(self.uv.reshape(-1, 2) * 65536)]).astype(np.int64)
        pairs, number = np.unique(rows, axis=0, return_inverse=True)
        again = np.r_[False, pairs[1:, 0] == pairs[:-1, 0]]
        new = np.where(again, len(self.vertices) - 1 + np.cumsum(again), pairs[:, 0])
        origin = np.r_[np.arange(len(self.vertices)), pairs[again, 0]]
        groups = (self.targets, self.components)
        targets, components = ({n: d[origin] for n, d in group.items()} for group in groups)
        faces = new[number.ravel()].reshape(-1, 3).astype(np.int32)
        return replace(
            self, vertices=self.vertices[origin], faces=faces, targets=targets,
            components=components,
        ), origin  # fmt: skip

    def of_facets(self, kept: BoolArray) -> MorphMesh:
        """The mesh with some of its facets (F,)."""
        uv = None if self.uv is None else self.uv[kept]
        return replace(self, faces=self.faces[kept], part=self.part[kept], uv=uv)

    def turned(self) -> MorphMesh:
        """The mesh with facets that face the other way."""
        faces = np.ascontiguousarray(self.faces[:, ::-1])
        return replace(self, faces=faces, uv=None if self.uv is None else self.uv[:, ::-1])

    def uv_of_vertices(self) -> NDArray[np.float32]:
        """Places (V, 2) of vertices on the texture, of a mesh that is cut at its seams."""
        out = np.zeros((len(self.vertices), 2), np.float32)
        if self.uv is not None:
            out[self.faces] = self.uv
        return out


def check_numbers(mesh: MorphMesh) -> None:
    """Raise `ModelFormatError` where a number of it is not finite, or no length of a head."""
    arrays: dict[str, NDArray[Any]] = {"vertices": mesh.vertices, **mesh.targets, **mesh.components}
    if mesh.uv is not None:
        arrays["places on the texture"] = mesh.uv
    layout = {name: real(*values.shape, dtype=values.dtype) for name, values in arrays.items()}
    check_arrays(Path(mesh.source), arrays, layout, "export the head again")


def displacement(
    name: str,
    moved: NDArray[np.floating],
    neutral: NDArray[np.floating],
    *,
    kind: str = "morph target",
) -> NDArray[np.float32]:
    """By how much a target, or what else `kind` says, moves each vertex, (V, 3).

    Raises
    ------
    ModelFormatError
        If it has another number of vertices than the neutral mesh.
    """
    if len(moved) != len(neutral):
        raise ModelFormatError(
            f"{kind} '{name}' has {len(moved)} vertices, the head has {len(neutral)}",
            "export all of them from one mesh, without merging or splitting vertices",
        )
    return np.asarray(moved - neutral, np.float32)
