"""Heads as glTF 2.0: every mesh of the scene that is drawn, with its morph targets by name."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pygltflib as gl
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from abs_engine.core.errors import InputFileError, ModelFormatError
from abs_engine.io.morphs.gltf_file import GltfFile
from abs_engine.io.morphs.mesh import MorphMesh
from abs_engine.io.pictures import decoded

_KINDS = {
    gl.BYTE: np.int8, gl.UNSIGNED_BYTE: np.uint8, gl.SHORT: np.int16, gl.UNSIGNED_SHORT: np.uint16,
    gl.UNSIGNED_INT: np.uint32, gl.FLOAT: np.float32,
}  # fmt: skip
_COLUMNS = {gl.SCALAR: 1, gl.VEC2: 2, gl.VEC3: 3, gl.VEC4: 4}
_TILE = 512  # pixels a side of each material's share of the texture
_TRIANGLES = 4  # glTF's number for lists of triangles
_FLAT = 3  # numbers of a look of one colour
_OF_INDICES = (gl.UNSIGNED_BYTE, gl.UNSIGNED_SHORT, gl.UNSIGNED_INT)
_MOST_NUMBERS = 1 << 25
"""In all arrays of a file together, and in all its morph targets."""
_MOST_PARTS = 256
_BROKEN = (ValueError, KeyError, IndexError, TypeError, AttributeError, OSError, OverflowError)


def read_gltf(path: Path) -> MorphMesh:
    """Read a GLB or glTF file.

    Raises
    ------
    InputFileError
        If it is missing, damaged, compressed, or has no triangles.
    ModelFormatError
        If a morph target has another number of vertices than its mesh.
    """
    try:
        return _Reader(path, GltfFile.read(path)).mesh()
    except _BROKEN as error:
        raise InputFileError(f"{path} is no whole glTF file", "export the head again") from error


@dataclass
class _Reader:
    """A document, and what was gathered of its primitives so far."""

    path: Path
    file: GltfFile
    vertices: list[NDArray[np.float64]] = field(default_factory=list)
    uv: list[NDArray[np.float64]] = field(default_factory=list)
    faces: list[NDArray[np.int64]] = field(default_factory=list)
    names: list[str] = field(default_factory=list)
    moved: list[tuple[str, int, NDArray[np.float64]]] = field(default_factory=list)
    looks: list[NDArray[np.uint8] | None] = field(default_factory=list)
    shared: dict[int, int] = field(default_factory=dict)
    count: int = 0
    taken: int = 0

    @property
    def document(self) -> gl.GLTF2:
        return self.file.document

    def mesh(self) -> MorphMesh:
        for node, world in self._nodes():
            self.shared.clear()  # another node's copy lies elsewhere
            mesh = self.document.meshes[node.mesh]
            for primitive in mesh.primitives:
                if primitive.mode in (None, _TRIANGLES):
                    self._add(f"{node.name or ''} / {mesh.name or ''}", mesh, primitive, world)
        if not self.faces:
            raise InputFileError(
                f"{self.path} has no triangles", "give a file with the head's mesh"
            )
        self._check_size(3 * self.count * len({name for name, *_ in self.moved}))
        targets: dict[str, NDArray[np.float32]] = {}
        for name, first, displaced in self.moved:
            whole = targets.setdefault(name, np.zeros((self.count, 3), np.float32))
            whole[first : first + len(displaced)] += displaced.astype(np.float32)
        sizes = [len(f) for f in self.faces]
        tiles, faces = self._tiles(), np.concatenate(self.faces).astype(np.int32)
        return MorphMesh(
            str(self.path), np.concatenate(self.vertices),
            faces,
            np.repeat(np.arange(len(sizes)), sizes).astype(np.int32), tuple(self.names), targets,
            uv=None if tiles is None else np.concatenate(self.uv).astype(np.float32)[faces],
            texture=tiles,
        )  # fmt: skip

    def _nodes(self) -> Iterator[tuple[gl.Node, NDArray[np.float64]]]:
        """Nodes that hold a mesh, and what takes them to the scene's coordinates."""
        nodes = self.document.nodes
        children = {child for node in nodes for child in node.children or ()}
        scene = self.document.scenes[self.document.scene or 0] if self.document.scenes else None
        roots = scene.nodes if scene else [k for k in range(len(nodes)) if k not in children]
        waiting, left = [(k, np.eye(4)) for k in roots or ()], len(nodes)
        while waiting:
            number, above = waiting.pop(0)
            left -= 1
            if left < 0:
                raise ValueError("a node stands below itself, or below two others")
            node = nodes[number]
            world = above @ _matrix(node)
            waiting += [(child, world) for child in node.children or ()]
            if node.mesh is not None:
                yield node, world

    def _add(self, name: str, mesh: gl.Mesh, primitive: gl.Primitive, world: Any) -> None:
        at = self._array(primitive.attributes.POSITION)
        if primitive.indices is None:
            corners = np.arange(len(at))
        else:
            corners = self._array(primitive.indices, _OF_INDICES).ravel().astype(np.int64)
        if len(corners) and corners.max() >= len(at):
            raise ValueError("indices of other vertices")
        uv, material = primitive.attributes.TEXCOORD_0, self._material(primitive.material)
        key = primitive.attributes.POSITION
        known = self.shared.get(key) if uv is None else None  # materials may share vertices
        first = self.count if known is None else known
        facets = corners[: len(corners) // 3 * 3].reshape(-1, 3) + first
        self.faces.append(facets[:, ::-1] if np.linalg.det(world[:3, :3]) < 0 else facets)
        if len(self.names) == _MOST_PARTS:
            raise InputFileError(f"{self.path} has more than {_MOST_PARTS} parts", "join some")
        self.names.append(f"{name} / {material.name if material else ''}")
        self.looks.append(self._look(material))
        if known is not None:
            return
        self.shared[key] = first
        self._add_targets(mesh, primitive, at, world[:3, :3])
        own = np.zeros((len(at), 2)) if uv is None else self._array(uv)
        if own.shape != (len(at), 2):
            raise ValueError("places on the texture of other vertices")
        own = np.where((own < 0) | (own > 1), own % 1.0, own)  # pictures repeat beyond their edges
        self.uv.append(np.c_[len(self.looks) - 1 + own[:, 0], own[:, 1]])
        self.vertices.append(at @ world[:3, :3].T + world[:3, 3])
        self.count += len(at)

    def _add_targets(
        self, mesh: gl.Mesh, primitive: gl.Primitive, at: NDArray[Any], turn: NDArray[Any]
    ) -> None:
        named = (mesh.extras or {}).get("targetNames") or []
        for k, target in enumerate(primitive.targets or ()):
            own = target.get("POSITION") if isinstance(target, dict) else target.POSITION
            label = str(named[k]) if k < len(named) else f"target {k}"
            displaced = np.zeros_like(at) if own is None else self._array(own)
            if len(displaced) != len(at):
                raise ModelFormatError(
                    f"morph target '{label}' has {len(displaced)} vertices, its mesh has {len(at)}",
                    "export all of them from one mesh, without merging or splitting vertices",
                )
            self.moved.append((label, self.count, displaced @ turn.T))

    def _material(self, number: int | None) -> gl.Material | None:
        return None if number is None else self.document.materials[number]

    def _look(self, material: gl.Material | None) -> NDArray[np.uint8] | None:
        """A material's picture (H, W, 3) RGB; one colour where it has none, None without either."""
        surface = None if material is None else material.pbrMetallicRoughness
        if surface is None:
            return None
        if surface.baseColorTexture is not None:
            number = self.document.textures[surface.baseColorTexture.index].source
            return self._image(self.document.images[number])
        linear = np.array(surface.baseColorFactor or (1, 1, 1, 1))[:3]
        return np.asarray(255 * linear ** (1 / 2.2), np.uint8).reshape(1, 1, 3)

    def _image(self, image: gl.Image) -> NDArray[np.uint8]:
        """A picture, no larger than its share of the texture."""
        if image.bufferView is not None:
            raw = bytes(self._view(image.bufferView))
        else:
            raw = self.file.bytes_at(image.uri)
        found = decoded(raw)
        if found is None:
            raise ValueError("a texture is no picture, or too large")
        if max(found.shape) <= _TILE:
            return found
        return np.asarray(cv2.resize(found, (_TILE, _TILE), interpolation=cv2.INTER_AREA), np.uint8)

    def _tiles(self) -> NDArray[np.uint8] | None:
        """All materials side by side, to which `uv` is brought; None if none has a picture."""
        if all(look is None or look.size == _FLAT for look in self.looks):
            return None
        plain = np.full((1, 1, 3), 200, np.uint8)
        size = (_TILE, _TILE)
        tiles = [
            cv2.resize(plain if look is None else look, size, interpolation=cv2.INTER_AREA)
            for look in self.looks
        ]
        for uv in self.uv:
            uv[:, 0] /= len(tiles)
        return np.hstack(tiles)

    def _check_size(self, numbers: int) -> None:
        """Refuse what takes too much memory, before it is taken."""
        if numbers > _MOST_NUMBERS:
            raise InputFileError(
                f"{self.path} has more than {_MOST_NUMBERS / 1e6:.0f} million numbers",
                "leave out meshes and morph targets that a talking face does not need",
            )

    def _view(self, number: int) -> memoryview:
        view = self.document.bufferViews[number]
        data = self.file.bytes_at(self.document.buffers[view.buffer].uri)
        first = view.byteOffset or 0
        if min(first, view.byteLength) < 0 or first + view.byteLength > len(data):
            raise ValueError("a view reaches beyond its buffer")
        return memoryview(data)[first : first + view.byteLength]

    def _array(self, number: int, kinds: Collection[int] = _KINDS) -> NDArray[Any]:
        """An accessor's values (N, C), sparse ones filled in."""
        accessor = self.document.accessors[number]
        if accessor.componentType not in kinds:
            raise ValueError("an accessor of another kind")
        kind, columns = np.dtype(_KINDS[accessor.componentType]), _COLUMNS[accessor.type]
        self.taken += accessor.count * columns
        self._check_size(self.taken)
        if accessor.bufferView is None:
            out = np.zeros((accessor.count, columns), kind)
        else:
            view = self.document.bufferViews[accessor.bufferView]
            out = _rows(
                self._view(accessor.bufferView), accessor.byteOffset or 0, accessor.count, columns,
                kind, view.byteStride,
            )  # fmt: skip
        if accessor.sparse is not None:
            places, values = accessor.sparse.indices, accessor.sparse.values
            if places.componentType not in _OF_INDICES:
                raise ValueError("a sparse accessor whose places are no whole numbers")
            kind_of_places = np.dtype(_KINDS[places.componentType])
            count = accessor.sparse.count
            at = _rows(self._view(places.bufferView), places.byteOffset or 0, count, 1,
                       kind_of_places)  # fmt: skip
            out = out.copy()
            out[at.ravel()] = _rows(
                self._view(values.bufferView), values.byteOffset or 0, count, columns, kind
            )
        if accessor.normalized:
            out = out / np.iinfo(out.dtype).max
        return np.asarray(out, np.float64)


def _rows(
    raw: memoryview, first: int, count: int, columns: int, kind: Any, stride: int | None = None
) -> NDArray[Any]:
    """Rows (N, C) of numbers, which others may lie between."""
    width = columns * kind.itemsize
    step = stride or width
    if count and len(raw) < first + step * (count - 1) + width:
        raise ValueError("an accessor reaches beyond its buffer")
    return np.ndarray((count, columns), kind, raw, first, (step, kind.itemsize))


def _matrix(node: gl.Node) -> NDArray[np.float64]:
    """Matrix (4, 4) from a node's own coordinates to those above it."""
    if node.matrix is not None:
        return np.array(node.matrix, np.float64).reshape(4, 4).T
    out = np.eye(4)
    turn = Rotation.from_quat(node.rotation or (0, 0, 0, 1)).as_matrix()
    out[:3, :3] = turn * np.array(node.scale or (1, 1, 1))
    out[:3, 3] = node.translation or (0, 0, 0)
    return out
