"""Refine the quads around the mouth once, as a linear operator that keeps the old vertices.

The new points are those of Catmull and Clark (1978), moved back by the mean of
what their scheme would have moved the old vertices; so the surface is smooth,
the lips keep their size, and the same matrix acts on the face units.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from speaker_mesh import EdgeMap, LipGrid


@dataclass(frozen=True)
class Refined:
    """A partly refined mesh of polygons.

    Attributes
    ----------
    matrix : (N', N) sparse
        Takes old points (or displacements) to new ones.
    uv_matrix : (T', T) sparse
        The same for the texture points (midpoints, so that the chart stays put).
    polygons, uv_polygons : list of list of int
        Corners, three to eight each.
    parent : (P,) int
        The old quad of each polygon.
    edge_point, face_point : dict
        New vertex of an old edge (pair of vertices), and of an old quad.
    """

    matrix: sparse.csr_matrix
    uv_matrix: sparse.csr_matrix
    polygons: list
    uv_polygons: list
    parent: np.ndarray
    edge_point: dict
    face_point: dict


def averaging(rows: np.ndarray, n: int) -> sparse.csr_matrix:
    """Return the matrix whose row i is the mean over the points rows[i]."""
    k = rows.shape[1]
    index = np.repeat(np.arange(len(rows)), k)
    return sparse.csr_matrix((np.full(rows.size, 1.0 / k), (index, rows.ravel())), (len(rows), n))


def incidence(rows: np.ndarray, n: int) -> sparse.csr_matrix:
    """Return the (n, len(rows)) matrix that averages, at each point, the rows it belongs to."""
    k = rows.shape[1]
    index = np.repeat(np.arange(len(rows)), k)
    table = sparse.csr_matrix((np.ones(rows.size), (rows.ravel(), index)), (n, len(rows)))
    count = np.maximum(np.asarray(table.sum(1)).ravel(), 1)
    return sparse.diags(1.0 / count) @ table


def smooth_points(mesh: EdgeMap, n: int) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
    """Return the operators of the edge points and of the face points.

    Notes
    -----
    Catmull and Clark: face point = mean of corners; edge point = mean of its ends and the two
    face points (midpoint on a border); vertex point = (F + 2 R + (n - 3) P) / n. The departure:
    the vertex stays, and its would-be displacement is taken from the new points instead.
    """
    face = averaging(mesh.quads, n)
    middle = averaging(mesh.edges, n)
    border = np.array([len(f) < 2 for f in mesh.faces])
    inside = np.zeros(n)
    inside[np.unique(mesh.quads)] = 1.0
    inside[mesh.edges[border]] = 0.0
    valence = np.maximum(np.bincount(mesh.edges.ravel(), minlength=n), 1)
    around = incidence(mesh.quads, n) @ face + 2.0 * (incidence(mesh.edges, n) @ middle)
    moved = sparse.diags(inside / valence) @ (around - 3.0 * sparse.identity(n, format="csr"))
    pairs = np.array([f if len(f) == 2 else [f[0], f[0]] for f in mesh.faces])
    sides = averaging(pairs, len(mesh.quads)) @ face
    weight = sparse.diags(np.where(border, 0.0, 0.5))
    edge = middle + weight @ (sides - middle) - weight @ (2.0 * (middle @ moved))
    return edge.tocsr(), (face - face @ moved).tocsr()


def refine(
    quads: np.ndarray, uv_quads: np.ndarray, n: int, n_uv: int, chosen: np.ndarray
) -> Refined:
    """Split the chosen quads into four and fit their neighbours to them.

    Parameters
    ----------
    quads, uv_quads : (Q, 4) int
        Corners of the mesh and of the chart.
    n, n_uv : int
        Number of points of each.
    chosen : (Q,) bool
        Quads to split.
    """
    mesh, chart = EdgeMap(quads), EdgeMap(uv_quads)
    edge_op, face_op = smooth_points(mesh, n)
    split = np.unique(mesh.of_quad[chosen])
    uv_split = np.unique(chart.of_quad[np.isin(mesh.of_quad, split)])
    rows = np.flatnonzero(chosen)
    edge_id = dict(zip(split.tolist(), range(n, n + len(split)), strict=True))
    face_id = dict(
        zip(rows.tolist(), range(n + len(split), n + len(split) + len(rows)), strict=True)
    )
    uv_edge_id = dict(zip(uv_split.tolist(), range(n_uv, n_uv + len(uv_split)), strict=True))
    start = n_uv + len(uv_split)
    uv_face_id = dict(zip(rows.tolist(), range(start, start + len(rows)), strict=True))
    matrix = sparse.vstack([sparse.identity(n), edge_op[split], face_op[rows]]).tocsr()
    uv_matrix = sparse.vstack(
        [
            sparse.identity(n_uv),
            averaging(chart.edges, n_uv)[uv_split],
            averaging(uv_quads, n_uv)[rows],
        ]
    ).tocsr()
    polygons, parent = cut_polygons(mesh, edge_id, face_id)
    uv_polygons, _ = cut_polygons(chart, uv_edge_id, uv_face_id)
    points = {tuple(mesh.edges[e]): v for e, v in edge_id.items()}
    return Refined(matrix, uv_matrix, polygons, uv_polygons, parent, points, face_id)


def cut_polygons(mesh: EdgeMap, edge_id: dict, face_id: dict) -> tuple[list, np.ndarray]:
    """List the polygons after the split, in the same order for the mesh and its chart.

    A quad that is not split takes up the new points on its sides.

    Returns
    -------
    polygons : list of list of int
        Corners; a polygon beside the split region begins at one of its new points.
    parent : (P,) int
        The old quad of each.
    """
    polygons, parent = [], []
    for q, corners in enumerate(mesh.quads.tolist()):
        sides = [edge_id.get(e, -1) for e in mesh.of_quad[q].tolist()]
        if q in face_id:
            polygons += [[corners[i], sides[i], face_id[q], sides[i - 1]] for i in range(4)]
            parent += [q] * 4
            continue
        polygon = [v for pair in zip(corners, sides, strict=True) for v in pair if v >= 0]
        first = next((polygon.index(v) for v in sides if v >= 0), 0)
        polygons.append(polygon[first:] + polygon[:first])
        parent.append(q)
    return polygons, np.array(parent)


def refine_grid(grid: LipGrid, made: Refined) -> LipGrid:
    """Return the lip grid of the refined mesh (every quad of it must have been split)."""
    rings, spokes = grid.quads.shape
    vertices = np.empty((2 * rings + 1, 2 * spokes), int)
    vertices[::2, ::2] = grid.vertices
    following = np.roll(grid.vertices, -1, 1)
    for r in range(rings + 1):
        for s in range(spokes):
            a, b = grid.vertices[r, s], following[r, s]
            vertices[2 * r, 2 * s + 1] = made.edge_point[(min(a, b), max(a, b))]
            if r < rings:
                c = grid.vertices[r + 1, s]
                vertices[2 * r + 1, 2 * s] = made.edge_point[(min(a, c), max(a, c))]
                vertices[2 * r + 1, 2 * s + 1] = made.face_point[int(grid.quads[r, s])]
    return LipGrid(vertices, 2 * grid.left, grid.quads)
