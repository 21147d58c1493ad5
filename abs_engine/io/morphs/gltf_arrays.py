"""Numbers of a glTF file by the accessors that name them, no more than memory is there for."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pygltflib as gl
from numpy.typing import NDArray

from abs_engine.core.errors import InputFileError
from abs_engine.io.morphs.gltf_file import DRACO, GltfFile

_KINDS = {
    gl.BYTE: np.int8, gl.UNSIGNED_BYTE: np.uint8, gl.SHORT: np.int16, gl.UNSIGNED_SHORT: np.uint16,
    gl.UNSIGNED_INT: np.uint32, gl.FLOAT: np.float32,
}  # fmt: skip
_COLUMNS = {gl.SCALAR: 1, gl.VEC2: 2, gl.VEC3: 3, gl.VEC4: 4, gl.MAT4: 16}
WHOLE_NUMBERS = (gl.UNSIGNED_BYTE, gl.UNSIGNED_SHORT, gl.UNSIGNED_INT)
_MOST_NUMBERS = 1 << 25
"""In all arrays of a file together, and in all its morph targets."""


@dataclass
class GltfArrays:
    """A file's accessors, and how many numbers were taken of them so far."""

    path: Path
    file: GltfFile
    taken: int = 0

    def check_size(self, numbers: int) -> None:
        """Refuse what takes too much memory, before it is taken."""
        if numbers > _MOST_NUMBERS:
            raise InputFileError(
                f"{self.path} has more than {_MOST_NUMBERS / 1e6:.0f} million numbers",
                "leave out meshes and morph targets that a talking face does not need",
            )

    def refuse_compressed(self, primitive: gl.Primitive) -> None:
        """Refuse a primitive whose places are in a Draco extension alone."""
        accessor = self.file.document.accessors[primitive.attributes.POSITION]
        bare = accessor.bufferView is None and accessor.sparse is None
        if bare and DRACO in (primitive.extensions or {}):
            raise InputFileError(f"{self.path} is compressed by {DRACO}", "export it without")

    def view(self, number: int) -> memoryview:
        """Bytes that a view of a buffer names."""
        view = self.file.document.bufferViews[number]
        data = self.file.bytes_at(self.file.document.buffers[view.buffer].uri)
        first = view.byteOffset or 0
        if min(first, view.byteLength) < 0 or first + view.byteLength > len(data):
            raise ValueError("a view reaches beyond its buffer")
        return memoryview(data)[first : first + view.byteLength]

    def read(self, number: int, kinds: Collection[int] = _KINDS) -> NDArray[Any]:
        """An accessor's values (N, C), sparse ones filled in."""
        accessor = self.file.document.accessors[number]
        if accessor.componentType not in kinds:
            raise ValueError("an accessor of another kind")
        kind, columns = np.dtype(_KINDS[accessor.componentType]), _COLUMNS[accessor.type]
        self.taken += accessor.count * columns
        self.check_size(self.taken)
        if accessor.bufferView is None:
            out = np.zeros((accessor.count, columns), kind)
        else:
            view = self.file.document.bufferViews[accessor.bufferView]
            out = _rows(
                self.view(accessor.bufferView), accessor.byteOffset or 0, accessor.count, columns,
                kind, view.byteStride,
            )  # fmt: skip
        if accessor.sparse is not None:
            out = self._filled(out, accessor.sparse)
        if accessor.normalized:
            out = np.maximum(out / np.iinfo(out.dtype).max, -1)  # glTF 2.0, 3.11
        return np.asarray(out, np.float64)

    def _filled(self, values: NDArray[Any], sparse: gl.Sparse) -> NDArray[Any]:
        """Values (N, C) with those that a sparse accessor gives."""
        places, own = sparse.indices, sparse.values
        if places.componentType not in WHOLE_NUMBERS:
            raise ValueError("a sparse accessor whose places are no whole numbers")
        kind = np.dtype(_KINDS[places.componentType])
        at = _rows(self.view(places.bufferView), places.byteOffset or 0, sparse.count, 1, kind)
        out = values.copy()
        out[at.ravel()] = _rows(
            self.view(own.bufferView), own.byteOffset or 0, sparse.count, values.shape[1],
            values.dtype,
        )  # fmt: skip
        return out


def _rows(
    raw: memoryview, first: int, count: int, columns: int, kind: Any, stride: int | None = None
) -> NDArray[Any]:
    """Rows (N, C) of numbers, which others may lie between."""
    width = columns * kind.itemsize
    step = stride or width
    if count and len(raw) < first + step * (count - 1) + width:
        raise ValueError("an accessor reaches beyond its buffer")
    return np.ndarray((count, columns), kind, raw, first, (step, kind.itemsize))
