"""The mesh of the lips and the skin around them, cut from a speaker: 204 nodes in six rings.

Basu et al. cut their shell from a head and mend it for finite elements by hand. Here the rings are
laid out instead: on the lips from the inner to the outer contour, then over the skin. Every node
is a point of a facet of the head, so whatever moves the head moves the shell.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from abs_engine.core.arrays import BoolArray, FloatArray, IntArray
from abs_engine.core.nearest import nearest_on_facets
from abs_engine.face.settings.shape import SHAPE
from abs_engine.face.shape.dots import ShellPoints
from abs_engine.face.shape.fem import Material, ThinShell
from abs_engine.face.shape.lip_edge import lip_edge
from abs_engine.io.assets import Speaker

COLUMNS = 34
LIP_ROWS = (0.0, 0.5, 1.0)  # from the inner contour to the outer one
SKIN_ROWS = (3.0, 6.5, 10.0)  # mm beyond the outer contour: as far as the nose lets
MATERIAL = Material(SHAPE.young, SHAPE.poisson, SHAPE.thickness, SHAPE.shear)
"""Of lips and skin alike."""


@dataclass(frozen=True, eq=False)
class LipShell(ShellPoints):
    """Places of the N nodes of a shell on a head, and their facets.

    `faces` (M, 3) are counter-clockwise from the front; `lip` (M,) marks those of the lips, the
    others are skin; `border` (N,) marks nodes of the outermost ring.
    """

    faces: NDArray[np.int32]
    lip: BoolArray
    border: BoolArray

    nodes = ShellPoints.at

    def elastic_at(self, nodes: FloatArray) -> ThinShell:
        """The shell as an elastic body whose nodes (N, 3), mm, are at rest where given."""
        springs = np.where(self.border, SHAPE.border_spring, 0.0)
        return ThinShell(nodes, self.faces, springs, MATERIAL)


def cut_lip_shell(speaker: Speaker) -> LipShell:
    """Lay the shell's nodes over a speaker's average head.

    Of 34 columns around the mouth and six rings: 204 nodes, 612 degrees of freedom.
    """
    vertices = speaker.vertices.astype(np.float64)
    inner, outer = _contours(speaker, vertices)
    lips = [inner + share * (outer - inner) for share in LIP_ROWS]
    skin = _skin_rings(speaker, vertices, outer, SKIN_ROWS)
    placed = [_on_lips(speaker, vertices, np.vstack(lips))]
    placed.append(_on_surface(speaker, vertices, speaker.facets_of("skin"), np.vstack(skin)))
    corners, weights = (np.concatenate(part) for part in zip(*placed, strict=True))
    faces, ring = _faces(len(LIP_ROWS) + len(SKIN_ROWS))
    border = np.arange(len(corners)) >= len(corners) - COLUMNS
    return LipShell(corners, weights, faces, ring < len(LIP_ROWS) - 1, border)


def skin_around(speaker: Speaker, reaches: tuple[float, ...]) -> ShellPoints:
    """Rings of skin `reaches` mm beyond the outer contour, as many points each as columns."""
    vertices = speaker.vertices.astype(np.float64)
    outer = _contours(speaker, vertices)[1]
    rings = np.vstack(_skin_rings(speaker, vertices, outer, reaches))
    return ShellPoints(*_on_surface(speaker, vertices, speaker.facets_of("skin"), rings))


def lips_besides(speaker: Speaker, between: int, inside: int) -> ShellPoints:
    """Rings of points on the lips besides the shell's own, from within.

    The shell's chords cut off what bulges: 1.7 mm RMS half way from the inner ring to the next, on
    full lips. And lips go on behind the inner contour, which shows as the mouth opens. There are so
    many `between` two of the shell's, and `inside`, the first of which is where the lips end.
    """
    vertices = speaker.vertices.astype(np.float64)
    inner, outer = _contours(speaker, vertices)
    upper, lower = lip_edge(speaker, "upper_lip"), lip_edge(speaker, "lower_lip")[::-1]
    edge = np.vstack([_evenly(part, COLUMNS // 2) for part in (upper, lower)])
    rings = [edge + (k / inside) * (inner - edge) for k in range(inside)]
    for low, high in itertools.pairwise(LIP_ROWS):
        shares = low + (high - low) * np.arange(1, between + 1) / (between + 1)
        rings += [inner + share * (outer - inner) for share in shares]
    return ShellPoints(*_on_lips(speaker, vertices, np.vstack(rings)))


def _skin_rings(
    speaker: Speaker, vertices: FloatArray, outer: FloatArray, reaches: tuple[float, ...]
) -> list[FloatArray]:
    centre = outer.mean(axis=0)
    away = (outer - centre) * [1.0, 1.6, 0.0]  # an ellipse's normals rather than its radii
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    return [_front(speaker, vertices, outer + reach * away) for reach in reaches]


def _contours(speaker: Speaker, vertices: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points (34, 3) of the inner and outer contour, from the right corner over the top."""
    marks = speaker.landmarks
    ring = vertices[marks["outer_lip"]]
    left = int(np.flatnonzero(marks["outer_lip"] == marks["mouth_corners"][1])[0])
    halves = ring[: left + 1], np.vstack([ring[left:], ring[:1]])
    inner = vertices[marks["inner_lip_upper"]], vertices[marks["inner_lip_lower"]][::-1]
    half = COLUMNS // 2
    return (
        np.vstack([_evenly(part, half) for part in inner]),
        np.vstack([_evenly(part, half) for part in halves]),
    )


def _evenly(line: FloatArray, count: int) -> FloatArray:
    """Points at equal distances along a line, from its beginning to just before its end."""
    along = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))]
    at = np.arange(count) / count * along[-1]
    return np.stack([np.interp(at, along, line[:, k]) for k in range(3)], axis=1)


def _front(speaker: Speaker, vertices: FloatArray, points: FloatArray) -> FloatArray:
    """Points (N, 3) moved along z to the depth of the skin in front of them."""
    skin = speaker.vertices_of("skin")
    near = skin[np.linalg.norm(vertices[skin] - points.mean(axis=0), axis=1) < 95]
    flat = np.linalg.norm(vertices[near, None, :2] - points[None, :, :2], axis=2)
    around = np.maximum(4.0, flat.min(axis=0) + 1.0)  # beside the chin there is none in front
    depth = np.where(flat < around, vertices[near, 2][:, None], -np.inf).max(axis=0)
    return np.column_stack([points[:, :2], depth])


def _on_lips(
    speaker: Speaker, vertices: FloatArray, points: FloatArray
) -> tuple[NDArray[np.int32], FloatArray]:
    """As `_on_surface`, each column of points on its own lip; the corners on the nearest."""
    upper, lower = speaker.facets_of("upper_lip"), speaker.facets_of("lower_lip")
    column, half = np.arange(len(points)) % COLUMNS, COLUMNS // 2
    corners = np.zeros((len(points), 3), np.int32)
    weights = np.zeros((len(points), 3))
    for lip, own in (
        (upper, (column > 0) & (column < half)),
        (lower, column > half),
        (upper | lower, column % half == 0),
    ):
        corners[own], weights[own] = _on_surface(speaker, vertices, lip, points[own])
    return corners, weights


def _on_surface(
    speaker: Speaker, vertices: FloatArray, chosen: BoolArray, points: FloatArray
) -> tuple[NDArray[np.int32], FloatArray]:
    """Facets' vertices (N, 3) and barycentrics (N, 3) nearest to points, of the chosen facets."""
    centre = vertices[speaker.faces].mean(axis=1)
    near = np.linalg.norm(centre - points.mean(axis=0), axis=1) < 95
    faces = speaker.faces[chosen & near]
    facet, place = nearest_on_facets(vertices[faces], points)
    corners = faces[facet]
    weights = [_barycentrics(*pair) for pair in zip(vertices[corners], place, strict=True)]
    return np.asarray(corners, np.int32), np.array(weights)


def _barycentrics(triangle: FloatArray, point: FloatArray) -> FloatArray:
    a, b, c = triangle
    basis = np.stack([b - a, c - a], axis=1)
    s, t = np.linalg.lstsq(basis, point - a, rcond=None)[0]
    return np.array([1 - s - t, s, t])


def _faces(rows: int) -> tuple[NDArray[np.int32], IntArray]:
    """Facets between neighbouring rings, and the ring at whose outer side each lies."""
    faces, ring = [], []
    for row in range(rows - 1):
        for column in range(COLUMNS):
            here, after = row * COLUMNS + column, row * COLUMNS + (column + 1) % COLUMNS
            out, out_after = here + COLUMNS, after + COLUMNS
            if (row + column) % 2:
                faces += [[here, after, out_after], [here, out_after, out]]
            else:
                faces += [[here, after, out], [after, out_after, out]]
            ring += [row, row]
    return np.array(faces, np.int32), np.array(ring)
