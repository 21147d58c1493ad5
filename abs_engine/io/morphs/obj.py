"""Heads as Wavefront OBJ files: a neutral one, and one for each morph target.

Vertices keep their numbers, which tables and other programs name them by; loaders that split or
merge them do not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.errors import InputFileError
from abs_engine.io.inputs import check_file, to_number
from abs_engine.io.morphs.mesh import MorphMesh, displacement

_PARTS = ("g", "o", "usemtl")


def read_obj(path: Path, deltas: Path | None) -> MorphMesh:
    """Read a neutral OBJ, and a folder of OBJs that are morph targets by their files' names.

    Raises
    ------
    InputFileError
        If a file is missing or no OBJ.
    ModelFormatError
        If a target has another number of vertices.
    """
    places, corners, parts, seen = _parsed(path)
    faces, of = _triangles(corners)
    uv = _on_texture(path, _triangles(seen)[0]) if any(map(any, seen)) else None
    names = tuple(dict.fromkeys(parts)) or ("",)
    part = np.array([names.index(parts[k]) for k in of], np.int32)
    others = [] if deltas is None else sorted(deltas.glob("*"))
    files = [p for p in others if p.suffix.lower() == ".obj" and p != path]
    targets = {p.stem: displacement(p.stem, read_places(p), places) for p in files}
    whole = None if uv is None else tiled(uv)
    return MorphMesh(str(path), places, faces, part, names, targets, uv=whole)


def read_places(path: Path) -> NDArray[np.float64]:
    """Vertices (V, 3) of an OBJ; errors as `read_obj`."""
    return _places(path, _lines(path))


def _parsed(path: Path) -> tuple[NDArray[np.float64], list[list[int]], list[str], list[list[int]]]:
    """Vertices, and of each polygon the corners, the part and the places on the texture."""
    lines = _lines(path)
    places, corners, parts, seen = _places(path, lines), [], [], []
    now, read = dict.fromkeys(_PARTS, ""), {"v": 0, "vt": 0}
    for word, rest in lines:
        if word in read:
            read[word] += 1
        elif word in now:
            now[word] = rest
        elif word == "f":
            at, on_texture = _corners(path, rest, len(places), read)
            corners.append(at)
            parts.append(" / ".join(name for name in now.values() if name))
            seen.append(on_texture)
    if not corners:
        raise InputFileError(f"{path} has no faces", "give an OBJ file of a mesh")
    return places, corners, parts, seen


def _on_texture(path: Path, corners: NDArray[np.int32]) -> NDArray[np.float32]:
    """Places (F, 3, 2) on a texture, in its tiles."""
    rows = [rest.split()[:2] for word, rest in _lines(path) if word == "vt"]
    try:
        numbers = [[0.0, 0.0], *([to_number(cell) for cell in row] for row in rows)]
        places = np.array(numbers, np.float32).reshape(len(numbers), 2)[corners]
    except (ValueError, IndexError) as error:
        raise _misplaced(path) from error
    return np.stack([places[..., 0], 1 - places[..., 1]], axis=-1)


def _misplaced(path: Path) -> InputFileError:
    return InputFileError(f"{path} has a wrong place on its texture", "export it again")


def tiled(uv: NDArray[np.float32]) -> NDArray[np.float32]:
    """Places (F, 3, 2) with all tiles, which lie side by side, in one picture.

    A facet is on the tile of its middle: corners may lie a little beyond it.
    """
    tiles = max(1.0, float(np.ceil(uv[..., 0].mean(axis=1).max() - 1e-4)))
    within = np.stack([np.minimum(uv[..., 0], tiles), uv[..., 1]], axis=-1)
    return np.asarray(within / [tiles, 1.0], np.float32)


def _lines(path: Path) -> list[tuple[str, str]]:
    """The first word of each line, and the rest of it."""
    check_file(path, "give an OBJ file")
    text = path.read_text(encoding="utf-8", errors="replace")
    cells = (line.split(maxsplit=1) for line in text.replace("\\\n", " ").splitlines())
    return [(c[0], c[1].strip() if len(c) > 1 else "") for c in cells if c]


def _places(path: Path, lines: Sequence[tuple[str, str]]) -> NDArray[np.float64]:
    try:
        rows = [rest.split()[:3] for word, rest in lines if word == "v"]
        places = np.array([[to_number(cell) for cell in row] for row in rows]).reshape(len(rows), 3)
    except ValueError as error:
        raise InputFileError(f"{path} has a vertex that is no place", "export it again") from error
    if not len(places):
        raise InputFileError(f"{path} has no vertices", "give an OBJ file of a mesh")
    return places


def _corners(
    path: Path, rest: str, count: int, read: Mapping[str, int]
) -> tuple[list[int], list[int]]:
    """Vertices of a polygon, from 0, and its places on the texture, from 1, 0 for none.

    `OBJ` counts from 1, or backwards from the last one that was read above the polygon.
    """
    try:
        cells = [f"{corner}/".split("/") for corner in rest.split()]
        numbers, seen = ([int(cell[k] or 0) for cell in cells] for k in (0, 1))
    except ValueError:
        numbers = seen = []
    out = [n - 1 if n > 0 else read["v"] + n for n in numbers]
    if len(out) < 3 or 0 in numbers or min(out) < 0 or max(out) >= count:
        raise InputFileError(f"{path} has a face 'f {rest}' of other vertices", "export it again")
    if min(seen) < -read["vt"]:  # NumPy would count on from the other end
        raise _misplaced(path)
    return out, [n if n >= 0 else read["vt"] + 1 + n for n in seen]


def _triangles(polygons: Sequence[Sequence[int]]) -> tuple[NDArray[np.int32], list[int]]:
    """Fans of triangles (F, 3), and the polygon of each."""
    faces, of = [], []
    for k, p in enumerate(polygons):
        fan = [(p[0], p[i], p[i + 1]) for i in range(1, len(p) - 1)]
        faces += fan
        of += [k] * len(fan)
    return np.array(faces, np.int32), of
