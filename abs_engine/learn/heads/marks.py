"""Landmarks of a head, and the contours of its lips along the mesh between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from abs_engine.core.arrays import FloatArray, IntArray
from abs_engine.core.errors import ParameterError
from abs_engine.core.geometry import edges_of
from abs_engine.io.arrays import of_json
from abs_engine.io.inputs import MOST
from abs_engine.learn.heads.settings import HEAD_IMPORT
from abs_engine.learn.heads.table import MARKS, SIXTY_EIGHT

_LEAST = {"outer_lip": 4, "inner_lip": 4, "nose_tip": 1, "chin": 1, "eye_corners": 4}
_OF_68: dict[str, Any] = {
    "outer_lip": slice(48, 60), "inner_lip": slice(60, 68), "nose_tip": [30], "chin": [8],
    "eye_corners": [36, 39, 42, 45],
}  # fmt: skip
OUTER, INNER = 12, 8
"""Points of the outer and of the inner contour among the usual 68."""


@dataclass(frozen=True, eq=False)
class Marks:
    """Landmarks as vertices; the subject's right comes first.

    Parameters
    ----------
    outer_lip, inner_lip : (N,) int64
        From the right corner over the upper lip to the left corner and back.
    nose_tip, chin : (1,) int64
    eye_corners : (4,) int64
        Right outer, right inner, left inner, left outer.
    all_68 : (68,) int64 or None
    """

    outer_lip: IntArray
    inner_lip: IntArray
    nose_tip: IntArray
    chin: IntArray
    eye_corners: IntArray
    all_68: IntArray | None = None


def find_marks(given: Mapping[str, Sequence[Any]], vertices: FloatArray, source: str) -> Marks:
    """Landmarks as vertices (V, 3), given by numbers or by places.

    Raises `ParameterError` if one is missing, is neither a vertex nor a place, or lies far from all
    vertices.
    """
    found = {name: _vertices(name, entries, vertices) for name, entries in given.items()}
    all_68 = found.pop(SIXTY_EIGHT, None)
    if all_68 is not None:
        if len(all_68) != 68:
            raise ParameterError(f"{SIXTY_EIGHT} has {len(all_68)} points", "give all 68")
        found = {name: all_68[at] for name, at in _OF_68.items()} | found
    lacking = [name for name in MARKS if len(found.get(name, ())) < _LEAST[name]]
    if lacking:
        raise ParameterError(
            f"{source} does not say where these lie: {', '.join(lacking)}",
            "give them under [landmarks] in a table, see docs/import.md: --table head.toml",
        )
    return Marks(**{name: found[name] for name in MARKS}, all_68=all_68)


def _vertices(name: str, entries: Sequence[Any], vertices: FloatArray) -> IntArray:
    """Vertices by their numbers, or the nearest to places."""
    out = []
    for entry in entries:
        place = of_json(entry)
        if place.dtype.kind in "iu" and place.ndim == 0 and 0 <= int(place) < len(vertices):
            out.append(int(place))
        elif place.dtype.kind in "iuf" and place.shape == (3,) and (abs(place) <= MOST).all():
            out.append(_nearest(name, place, vertices))
        else:
            raise ParameterError(
                f"landmark {name}: {entry} is no vertex of {len(vertices)} and no place",
                "give numbers of vertices from 0, or [x, y, z] in the file's unit",
            )
    return np.array(out, np.int64)


def _nearest(name: str, place: FloatArray, vertices: FloatArray) -> int:
    """The vertex nearest to a place; `ParameterError` if that is in another frame or unit."""
    away = np.linalg.norm(vertices - place, axis=1)
    nearest, least, most = int(away.argmin()), vertices.min(axis=0), vertices.max(axis=0)
    if away[nearest] > HEAD_IMPORT.off_mesh * (most - least).max():
        low, high = ("[" + ", ".join(f"{x:.4g}" for x in corner) + "]" for corner in (least, most))
        raise ParameterError(
            f"landmark {name}: no vertex is near {place.tolist()}",
            f"give places in the unit and axes of the file: its mesh reaches from {low} to {high}",
        )
    return nearest


@dataclass(frozen=True, eq=False)
class Contours:
    """The lips' contours along the mesh, as vertices.

    Parameters
    ----------
    over, under : (N,) int64
        The outer contour above and below, from the right corner to the left one.
    upper, lower : (N,) int64
        The inner contours, likewise.
    right, left : (N,) int64
        From the outer to the inner corner.
    points : (20,) int64
        The 12 outer and 8 inner ones of the usual 68.
    """

    over: IntArray
    under: IntArray
    upper: IntArray
    lower: IntArray
    right: IntArray
    left: IntArray
    points: IntArray

    @property
    def outer(self) -> IntArray:
        """The outer contour, a closed loop from the right corner over the upper lip."""
        return np.concatenate([self.over, self.under[-2:0:-1]])


def lip_contours(
    marks: Marks, vertices: FloatArray, faces: NDArray[np.integer], weld: IntArray
) -> Contours:
    """Shortest ways along the edges of a mesh through the landmarks of the lips.

    Raises `ParameterError` if no edges join them.
    """
    count = int(weld.max()) + 1
    place = np.zeros((count, 3))
    place[weld] = vertices
    edges, _ = edges_of(weld[faces])
    length = np.linalg.norm(place[edges[:, 0]] - place[edges[:, 1]], axis=1)
    graph = csr_matrix((np.maximum(length, 1e-6), (edges[:, 0], edges[:, 1])), (count, count))
    first, used = np.zeros(count, np.int64), np.unique(faces)[::-1]
    first[weld[used]] = used  # not a copy that another material's facets leave unused
    across = vertices[:, 0]

    def way(through: IntArray) -> IntArray:
        return first[_path(graph, weld[through])]

    def halves(ring: IntArray) -> tuple[IntArray, IntArray]:
        left = int(across[ring].argmax())
        return ring[: left + 1], np.r_[ring[0], ring[: left - 1 : -1]] if left else ring[:1]

    over, under = (way(half) for half in halves(marks.outer_lip))
    upper, lower = (way(half) for half in halves(marks.inner_lip))
    right, left = (way(np.array([over[k], upper[k]])) for k in (0, -1))
    outer = [*_spread(over, vertices, 7), *_spread(under, vertices, 7)[5:0:-1]]
    inner = [*_spread(upper, vertices, 5), *_spread(lower, vertices, 5)[3:0:-1]]
    given = marks.all_68 is not None
    points = np.r_[marks.outer_lip, marks.inner_lip] if given else np.array([*outer, *inner])
    return Contours(over, under, upper, lower, right, left, first[weld[points]])


def _path(graph: csr_matrix, through: IntArray) -> IntArray:
    out = [int(through[0])]
    for start, end in pairwise(through):
        away, before = dijkstra(graph, directed=False, indices=start, return_predecessors=True)
        if not np.isfinite(away[end]):
            raise ParameterError(
                "no edges join the landmarks of the lips", "give landmarks on one connected mesh"
            )
        leg = [int(end)]
        while leg[-1] != start:
            leg.append(int(before[leg[-1]]))
        out += leg[-2::-1]
    return np.array(out)


def _spread(path: IntArray, vertices: FloatArray, count: int) -> IntArray:
    """So many vertices of a path, both ends among them, about equally far apart."""
    steps = np.linalg.norm(np.diff(vertices[path], axis=0), axis=1)
    along = np.r_[0.0, np.cumsum(steps)]
    return path[[int(np.abs(along - at).argmin()) for at in np.linspace(0, along[-1], count)]]
