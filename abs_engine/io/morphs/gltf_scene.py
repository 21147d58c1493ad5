"""Places of the meshes of a glTF file in its scene: by their nodes, or by the joints of a skin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pygltflib as gl
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from abs_engine.core.arrays import FloatArray
from abs_engine.io.morphs.gltf_arrays import WHOLE_NUMBERS, GltfArrays

_MOST_SETS = 4
"""Of four joints each, that a vertex may go with."""


@dataclass(frozen=True, eq=False)
class Placement:
    """Affine map from a mesh's own coordinates to those of the scene.

    Parameters
    ----------
    matrix : (4, 4) or (V, 4, 4) float64
        One for each vertex where the mesh has a skin.
    """

    matrix: FloatArray

    def places(self, at: FloatArray) -> FloatArray:
        """Places (V, 3)."""
        return self.moves(at) + self.matrix[..., :3, 3]

    def moves(self, displaced: FloatArray) -> FloatArray:
        """Displacements (V, 3)."""
        turn = self.matrix[..., :3, :3]
        if turn.ndim == 2:
            return np.asarray(displaced @ turn.T)
        return np.asarray((turn @ displaced[..., None])[..., 0])

    @property
    def mirrors(self) -> bool:
        """Whether it turns facets inside out."""
        return bool(np.linalg.det(self.matrix[..., :3, :3]).mean() < 0)


def worlds(document: gl.GLTF2) -> dict[int, FloatArray]:
    """Matrices (4, 4) from the nodes of the scene to its coordinates, by their numbers."""
    nodes = document.nodes
    children = {child for node in nodes for child in node.children or ()}
    scene = document.scenes[document.scene or 0] if document.scenes else None
    roots = scene.nodes if scene else [k for k in range(len(nodes)) if k not in children]
    waiting, left = [(k, np.eye(4)) for k in roots or ()], len(nodes)
    out: dict[int, FloatArray] = {}
    while waiting:
        number, above = waiting.pop(0)
        left -= 1
        if left < 0:
            raise ValueError("a node stands below itself, or below two others")
        node = nodes[number]
        out[number] = above @ _matrix(node)
        waiting += [(child, out[number]) for child in node.children or ()]
    return out


def placement(
    arrays: GltfArrays, node: gl.Node, own: gl.Attributes, world: dict[int, FloatArray], at: int
) -> Placement:
    """Placement of a primitive of the node numbered `at`.

    A mesh with a skin goes with its joints as they stand in the scene; its node's own place says
    nothing then (glTF 2.0, 3.7.3).
    """
    if node.skin is None or own.JOINTS_0 is None:
        return Placement(world[at])
    skin = arrays.file.document.skins[node.skin]
    joints = np.array([world[k] for k in skin.joints])
    if skin.inverseBindMatrices is not None:
        bound = arrays.read(skin.inverseBindMatrices).reshape(-1, 4, 4).transpose(0, 2, 1)
        joints = joints @ bound[: len(joints)]
    sets = [k for k in range(_MOST_SETS) if hasattr(own, f"WEIGHTS_{k}")]
    read = [arrays.read(getattr(own, f"JOINTS_{k}"), WHOLE_NUMBERS) for k in sets]
    numbers = np.hstack(read).astype(np.int64)
    weights = np.hstack([arrays.read(getattr(own, f"WEIGHTS_{k}")) for k in sets])
    arrays.check_size(16 * numbers.size)
    share = weights / np.maximum(weights.sum(axis=1, keepdims=True), 1e-12)
    return Placement(np.einsum("vj,vjab->vab", share, joints[numbers]))


def _matrix(node: gl.Node) -> NDArray[np.float64]:
    """Matrix (4, 4) from a node's own coordinates to those above it."""
    if node.matrix is not None:
        return np.array(node.matrix, np.float64).reshape(4, 4).T
    out = np.eye(4)
    turn = Rotation.from_quat(node.rotation or (0, 0, 0, 1)).as_matrix()
    out[:3, :3] = turn * np.array(node.scale or (1, 1, 1))
    out[:3, 3] = node.translation or (0, 0, 0)
    return out
