"""Heads as glTF 2.0: every mesh of the scene that is drawn, with its morph targets by name."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pygltflib as gl
from numpy.typing import NDArray

from abs_engine.core.arrays import FloatArray
from abs_engine.core.errors import InputFileError, ModelFormatError
from abs_engine.io.morphs.gltf_arrays import WHOLE_NUMBERS, GltfArrays
from abs_engine.io.morphs.gltf_file import GltfFile
from abs_engine.io.morphs.gltf_look import Look, look_of, side_by_side
from abs_engine.io.morphs.gltf_scene import Placement, placement, worlds
from abs_engine.io.morphs.mesh import MorphMesh

_LIST, _STRIP, _FAN = 4, 5, 6  # glTF's numbers for ways to list triangles
_MOST_PARTS = 256
_BROKEN = (ValueError, KeyError, IndexError, TypeError, AttributeError, OSError, OverflowError)


def read_gltf(path: Path) -> MorphMesh:
    """Read a GLB or glTF file.

    Raises
    ------
    InputFileError
        If it is missing, damaged, compressed, needs an extension that is not known, or has no
        triangles or pictures of another kind.
    ModelFormatError
        If a morph target has another number of vertices than its mesh, or two of a mesh have one
        name and differ.
    """
    try:
        return _Reader(GltfArrays(path, GltfFile.read(path))).mesh()
    except _BROKEN as error:
        raise InputFileError(f"{path} is no whole glTF file", "export the head again") from error


@dataclass
class _Reader:
    """A document, and what was gathered of its primitives so far."""

    arrays: GltfArrays
    vertices: list[FloatArray] = field(default_factory=list)
    uv: list[FloatArray] = field(default_factory=list)
    faces: list[NDArray[np.int64]] = field(default_factory=list)
    names: list[str] = field(default_factory=list)
    moved: list[tuple[str, int, FloatArray]] = field(default_factory=list)
    looks: list[Look] = field(default_factory=list)
    shared: dict[int, int] = field(default_factory=dict)
    count: int = 0

    def mesh(self) -> MorphMesh:
        document, path = self.arrays.file.document, self.arrays.path
        world = worlds(document)
        for number in world:
            node = document.nodes[number]
            if node.mesh is None:
                continue
            self.shared.clear()  # another node's copy lies elsewhere
            mesh = document.meshes[node.mesh]
            for primitive in mesh.primitives:
                if primitive.mode in (None, _LIST, _STRIP, _FAN):
                    place = placement(self.arrays, node, primitive.attributes, world, number)
                    self._add(f"{node.name or ''} / {mesh.name or ''}", mesh, primitive, place)
        if not self.faces:
            raise InputFileError(f"{path} has no triangles", "give a file with the head's mesh")
        self.arrays.check_size(3 * self.count * len({name for name, *_ in self.moved}))
        targets: dict[str, NDArray[np.float32]] = {}
        for name, first, displaced in self.moved:
            whole = targets.setdefault(name, np.zeros((self.count, 3), np.float32))
            whole[first : first + len(displaced)] += displaced.astype(np.float32)
        sizes, tiles = [len(f) for f in self.faces], side_by_side(self.looks)
        uv = [np.array([k, 0.0]) + own for k, own in enumerate(self.uv)]
        return MorphMesh(
            str(path), np.concatenate(self.vertices),
            np.concatenate(self.faces).astype(np.int32),
            np.repeat(np.arange(len(sizes)), sizes).astype(np.int32), tuple(self.names), targets,
            uv=None if tiles is None else (np.concatenate(uv) / [len(uv), 1]).astype(np.float32),
            texture=tiles,
        )  # fmt: skip

    def _add(self, name: str, mesh: gl.Mesh, primitive: gl.Primitive, place: Placement) -> None:
        read = self.arrays.read
        self.arrays.refuse_compressed(primitive)
        at, key = read(primitive.attributes.POSITION), primitive.attributes.POSITION
        if primitive.indices is None:
            corners = np.arange(len(at))
        else:
            corners = read(primitive.indices, WHOLE_NUMBERS).ravel().astype(np.int64)
        if len(corners) and corners.max() >= len(at):
            raise ValueError("indices of other vertices")
        facets = _facets(corners, primitive.mode)
        facets = facets[:, ::-1] if place.mirrors else facets
        if len(self.names) == _MOST_PARTS:
            raise InputFileError(
                f"{self.arrays.path} has more than {_MOST_PARTS} parts", "join some"
            )
        material = (
            None
            if primitive.material is None
            else self.arrays.file.document.materials[primitive.material]
        )
        self.names.append(f"{name} / {material.name if material else ''}")
        self.looks.append(look_of(self.arrays, material))
        self.uv.append(self._on_picture(primitive, facets, len(at)))
        # Materials may share vertices, but for those with texture coordinates
        known = self.shared.get(key) if primitive.attributes.TEXCOORD_0 is None else None
        first = self.count if known is None else known
        self.faces.append(facets + first)
        if known is not None:
            return
        self.shared[key] = first
        self._add_targets(mesh, primitive, at, place)
        self.vertices.append(place.places(at))
        self.count += len(at)

    def _on_picture(
        self, primitive: gl.Primitive, facets: NDArray[np.int64], count: int
    ) -> FloatArray:
        """Places (F, 3, 2) of facets on the picture that was read last."""
        look = self.looks[-1]
        number = getattr(primitive.attributes, f"TEXCOORD_{look.uses}", None)
        own = np.zeros((count, 2)) if number is None else self.arrays.read(number)
        if own.shape != (count, 2):
            raise ValueError("places on the texture of other vertices")
        return look.places(own[facets])

    def _add_targets(
        self, mesh: gl.Mesh, primitive: gl.Primitive, at: FloatArray, place: Placement
    ) -> None:
        named = next(filter(None, map(_target_names, (mesh, primitive))), [])
        known: dict[str, FloatArray] = {}
        for k, target in enumerate(primitive.targets or ()):
            own = target.get("POSITION") if isinstance(target, dict) else target.POSITION
            label = str(named[k]) if k < len(named) else f"target {k}"
            displaced = np.zeros_like(at) if own is None else self.arrays.read(own)
            if len(displaced) != len(at):
                raise ModelFormatError(
                    f"morph target '{label}' has {len(displaced)} vertices, its mesh has {len(at)}",
                    "export all of them from one mesh, without merging or splitting vertices",
                )
            if not np.array_equal(known.setdefault(label, displaced), displaced):
                raise ModelFormatError(
                    f"two morph targets of one mesh are called '{label}', and differ",
                    "give each its own name, or leave one out",
                )
            if known[label] is displaced:
                self.moved.append((label, self.count, place.moves(displaced)))


def _target_names(holder: gl.Mesh | gl.Primitive) -> list[Any]:
    """Names of morph targets in a holder's `extras`."""
    named: Any = (holder.extras or {}).get("targetNames")
    return named if isinstance(named, list) else []


def _facets(corners: NDArray[np.int64], mode: int | None) -> NDArray[np.int64]:
    """Triangles (F, 3) of a list, a strip or a fan (glTF 2.0, 3.7.2.1)."""
    if mode not in (_STRIP, _FAN):
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    k = np.arange(max(len(corners) - 2, 0))
    at = (k, k + 1 + k % 2, k + 2 - k % 2) if mode == _STRIP else (k + 1, k + 2, 0 * k)
    facets = corners[np.stack(at, axis=1)]
    joined = (facets == np.roll(facets, 1, axis=1)).any(axis=1)  # one strip to the next
    return np.asarray(facets[~joined])
