"""Cut the head out of the base mesh, name its parts, refine the mouth, lay out the texture.

Refinement is a linear operator, so one sparse matrix serves the vertices and every target alike.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from speaker_source import QuadMesh

CLASS_NAMES = (
    "background",
    "skin",
    "upper_lip",
    "lower_lip",
    "inner_mouth",
    "upper_teeth",
    "lower_teeth",
    "tongue",
    "eyes",
)
SKIN, UPPER_LIP, LOWER_LIP, INNER_MOUTH, UPPER_TEETH, LOWER_TEETH, TONGUE, EYES = range(1, 9)
GROUP_CLASS = {
    "helper-upper-teeth": UPPER_TEETH,
    "helper-lower-teeth": LOWER_TEETH,
    "helper-tongue": TONGUE,
    "helper-l-eye": EYES,
    "helper-r-eye": EYES,
}
NECK_PLANE = (0.0, 1.0, 0.33, 0.95)  # a x + b y + c z + d > 0 is kept; dm from the ear canals
SOCKET_CUT = 1.25  # dm, the parts of the eye sockets behind this depth are never seen
CONTACT_RING = 12  # of the refined lip grid: where the lips touch, seen from the front
LIP_RINGS = 7  # rings of quads from the seam inside the mouth to the vermilion border


def above_neck(points: np.ndarray) -> np.ndarray:
    """Return the height of points (dm from the ear canals) over the plane that cuts the neck."""
    return points @ np.array(NECK_PLANE[:3]) + NECK_PLANE[3]


def keep_head(base: QuadMesh, height: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Choose the quads of the head and give each the class known from its group.

    Parameters
    ----------
    base : QuadMesh
        The whole body.
    height : (N,) float64
        Height of its points over the plane of the cut.

    Returns
    -------
    rows : (Q,) int
        Rows of `base.quads` that are kept; those on the plane are kept whole.
    kind : (Q,) uint8
        Classes, with everything of the body still called skin.
    """
    centre = base.points[base.quads].mean(1)
    high = (height[base.quads] > 0).any(1) & (centre[:, 1] > 5.0)
    body = (base.group == "body") & high & (np.abs(centre[:, 0]) < 1.2)
    socket = base.uv[base.uv_quads].mean(1)[:, 0] < 0.16
    body &= ~(socket & (centre[:, 2] < SOCKET_CUT))
    rows = np.flatnonzero(body | np.isin(base.group, list(GROUP_CLASS)))
    kind = np.array([GROUP_CLASS.get(g, SKIN) for g in base.group[rows]], np.uint8)
    return rows, kind


def trim(quads: np.ndarray, corners: np.ndarray, n: int, height: np.ndarray) -> sparse.csr_matrix:
    """Return the matrix that draws the vertices below the cut up to its plane.

    Parameters
    ----------
    quads : (Q, 4) int
        Corners, into the points that `height` belongs to.
    corners : (Q, 4) int
        The same corners as rows of what the matrix acts on (points, or chart points).
    n : int
        Number of those rows.
    height : (N,) float64
        Height over the plane.

    Returns
    -------
    matrix : (n, n) sparse
        A vertex below the plane goes to the mean of the crossings of its edges
        (of its diagonals, if no edge crosses); the others stay.
    """
    ends: dict[int, list[tuple[int, float]]] = {}
    for step in (1, 3, 2):
        known = set(ends) if step == 2 else set()
        for low, high, a, b in zip(
            quads.ravel(),
            np.roll(quads, -step, 1).ravel(),
            corners.ravel(),
            np.roll(corners, -step, 1).ravel(),
            strict=True,
        ):
            if height[low] < 0 < height[high] and a not in known:
                share = height[low] / (height[low] - height[high])
                ends.setdefault(int(a), []).append((int(b), float(share)))
    matrix = sparse.identity(n, format="lil")
    for a, found in ends.items():
        matrix[a, a] = 0.0
        for b, share in found:
            matrix[a, b] += share / len(found)
            matrix[a, a] += (1.0 - share) / len(found)
    return matrix.tocsr()


class EdgeMap:
    """Edges of a set of polygons of equal length, and the faces on both sides.

    Parameters
    ----------
    quads : (Q, 4) int
        Corner indices.
    """

    def __init__(self, quads: np.ndarray) -> None:
        self.quads = quads
        pairs = np.stack([quads, np.roll(quads, -1, 1)], 2).reshape(-1, 2)
        self.edges, inverse = np.unique(np.sort(pairs, 1), axis=0, return_inverse=True)
        self.of_quad = inverse.reshape(len(quads), 4)
        self.faces: list[list[int]] = [[] for _ in self.edges]
        for q, row in enumerate(self.of_quad):
            for e in row:
                self.faces[e].append(q)

    def across(self, quad: int, edge: int) -> tuple[int, int] | None:
        """Step over `edge` from `quad`; return the next quad and its opposite edge."""
        other = [q for q in self.faces[edge] if q != quad]
        if not other:
            return None
        place = list(self.of_quad[other[0]]).index(edge)
        return other[0], int(self.of_quad[other[0]][(place + 2) % 4])

    def neighbours(self, chosen: np.ndarray) -> np.ndarray:
        """Return a mask of `chosen` quads grown by one ring over shared vertices."""
        touched = np.zeros(self.quads.max() + 1, bool)
        touched[self.quads[chosen]] = True
        return touched[self.quads].any(1)


def order_loop(edges: np.ndarray) -> list[int]:
    """Walk edges that form one closed loop; return its vertices in order."""
    links: dict[int, list[int]] = {}
    for a, b in edges:
        links.setdefault(int(a), []).append(int(b))
        links.setdefault(int(b), []).append(int(a))
    loop = [min(links)]
    previous, current = -1, loop[0]
    while True:
        step = [v for v in links[current] if v != previous]
        previous, current = current, step[0]
        if current == loop[0]:
            return loop
        loop.append(current)


@dataclass(frozen=True)
class LipGrid:
    """The lips as a regular grid of vertices.

    Attributes
    ----------
    vertices : (rings + 1, spokes) int
        Row 0 is the vermilion border, the last row the seam inside the mouth.
        Columns run from the subject's right corner along the upper lip to the
        left corner and back along the lower lip.
    left : int
        The column of the left corner (column 0 is the right one).
    quads : (rings, spokes) int
        The quads between; column j lies between the spokes j and j + 1.
    """

    vertices: np.ndarray
    left: int
    quads: np.ndarray


def lip_grid(mesh: EdgeMap, points: np.ndarray, inner: np.ndarray, outer: np.ndarray) -> LipGrid:
    """Walk outwards from the seam between inner mouth and lips.

    Parameters
    ----------
    mesh : EdgeMap
        Quads of the head.
    points : (N, 3) float64
        Vertex positions, used to find the mouth's corners and to orient the loop.
    inner, outer : (Q,) bool
        Quads of the inner mouth, and of the skin around it.
    """
    seam = [
        e
        for e, faces in enumerate(mesh.faces)
        if len(faces) == 2 and inner[faces].any() and outer[faces].any()
    ]
    loop = order_loop(mesh.edges[seam])
    loop = orient_loop(loop, points)
    by_pair = {tuple(sorted(mesh.edges[e])): e for e in seam}
    columns, quads = [], []
    for a, b in zip(loop, loop[1:] + loop[:1], strict=True):
        edge = by_pair[tuple(sorted((a, b)))]
        quad = next(q for q in mesh.faces[edge] if inner[q])
        start, row, column = a, [a], []
        for _ in range(LIP_RINGS):
            quad, far = mesh.across(quad, edge)
            start = next(int(v) for v in mesh.edges[far] if has_edge(mesh, quad, start, int(v)))
            row.append(start)
            column.append(quad)
            edge = far
        columns.append(row[::-1])
        quads.append(column[::-1])
    grid = np.array(columns).T
    return LipGrid(grid, int(points[grid[-1], 0].argmax()), np.array(quads).T)


def has_edge(mesh: EdgeMap, quad: int, a: int, b: int) -> bool:
    """Tell whether the quad has the edge (a, b)."""
    return any(set(mesh.edges[e]) == {a, b} for e in mesh.of_quad[quad])


def orient_loop(loop: list[int], points: np.ndarray) -> list[int]:
    """Start a mouth loop at the right corner (smallest x) and go along the upper lip first."""
    start = int(points[loop, 0].argmin())
    loop = loop[start:] + loop[:start]
    half = int(points[loop, 0].argmax())
    first, second = points[loop[1:half], 1].mean(), points[loop[half + 1 :], 1].mean()
    return loop if first > second else loop[:1] + loop[:0:-1]


@dataclass(frozen=True)
class Head:
    """The head before it is written.

    Attributes
    ----------
    vertices : (V, 3) float64
        The average person, mm, head frame.
    faces : (F, 3) int
    uv : (V, 2) float64
    weld : (V,) int
    facet_class : (F,) uint8
    lips : LipGrid
        The lips' grid, in split vertices.
    border : (spokes,) int
        Ring of the vermilion border at each spoke of the grid.
    operator : (V, N) sparse
        From points of the base mesh to vertices (mm, but not moved to the origin).
    points : (N, 3) float64
        The average person over the base mesh, dm.
    origin : (3,) float64
        Origin of the head frame in the base mesh, dm.
    canals : (2,) int
        Base points at the right and left ear canal; the origin is between them.
    """

    vertices: np.ndarray
    faces: np.ndarray
    uv: np.ndarray
    weld: np.ndarray
    facet_class: np.ndarray
    lips: LipGrid
    border: np.ndarray
    operator: sparse.csr_matrix
    points: np.ndarray
    origin: np.ndarray
    canals: np.ndarray
